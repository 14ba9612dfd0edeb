// Streaks out of focus (raytrace/depth_of_field.h, realtime/shaders/rain_defocus.glsl).
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "raytrace/depth_of_field.h"
#include "raytrace/drop_field.h"
#include "raytrace/rain_space.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A drop that falls through the picture's middle in the plane of the picture, slanted by its angle
// from straight down, before a black sky.
Scene one_streak(double depth_m, double slant_deg, double fov_deg = 20) {
  Scene scene;
  scene.camera.width_px = 320;
  scene.camera.height_px = 320;
  scene.camera.position_m = {0, 0, 1.6};
  scene.camera.target_m = {0, 5, 1.6};
  scene.camera.vertical_fov_deg = fov_deg;
  scene.lights = {{"lamp", {-1, 3, 3}, {90, 70, 40}}, {"behind", {1, 8, 1}, {10, 30, 50}}};
  const double slant = slant_deg * 3.14159265358979 / 180;
  const Eigen::Vector3d velocity = 8.49 * Eigen::Vector3d(std::sin(slant), 0, -std::cos(slant));
  // Not at the camera's own height, where float and double may see it from above or from below.
  const Eigen::Vector3d middle(0, depth_m, 1.6 - 0.01 * depth_m);
  scene.drops = {{.centre_m = middle - velocity / 120,
                  .velocity_m_s = velocity,
                  .oscillation = 3}};
  return scene;
}

// Out of focus by a circle of radius_px, focused behind the drop.
void defocus(Scene& scene, double radius_px, double depth_m) {
  const double focal_px = camera_frame(scene.camera).focal_px;
  scene.camera.depth_of_field = DepthOfField{.aperture_m = 2 * radius_px * depth_m / focal_px};
}

struct Flux {
  Eigen::Vector3d light = {0, 0, 0};
  double coverage = 0;
};

Flux flux_of(const Frame& frame) {
  Flux flux;
  for (std::size_t i = 0; i < frame.rain_tau.values.size(); ++i) {
    flux.light += Eigen::Vector3f(&frame.rain.values[3 * i]).cast<double>();
    flux.coverage += -std::expm1(-static_cast<double>(frame.rain_tau.values[i]));
  }
  return flux;
}

// The same of the exact composite, without a lens.
Flux exact_flux(const Scene& scene, const StreakAtlas& atlas) {
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  const int width = scene.camera.width_px, height = scene.camera.height_px;
  Image background = make_image(width, height, 3), depth_m = make_image(width, height, 1);
  std::fill(depth_m.values.begin(), depth_m.values.end(), std::numeric_limits<float>::infinity());
  Flux flux;
  const auto sum = [&](const Scene& lit) {
    const Image rain =
        composite_frame(lit, atlas, drops, sky_of(lit, atlas, 0), background, depth_m).rain;
    Eigen::Vector3d all(0, 0, 0);
    for (std::size_t i = 0; i < rain.values.size(); i += 3)
      all += Eigen::Vector3f(&rain.values[i]).cast<double>();
    return all;
  };
  flux.light = sum(scene);
  Scene dark = scene;
  dark.lights.clear();
  std::fill(background.values.begin(), background.values.end(), 1.0f);
  flux.coverage = -sum(dark).x();
  return flux;
}

TEST(Lens, NoLightIsLostOrMade) {
  PLUVIA_NEEDS_OPENGL();
  double worst = 0;
  for (const double slant_deg : {0.0, 11.0, 30.0, 44.0, 60.0, 90.0}) {
    for (const double depth_m : {0.6, 3.0}) {
      for (const double radius_px : {0.15, 0.9, 1.5, 4.3, 21.0, 60.0}) {
        Scene scene = one_streak(depth_m, slant_deg, depth_m < 1 ? 45 : 20);
        const Flux exact = exact_flux(scene, quarter_atlas());
        const Flux sharp =
            flux_of(RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0));
        defocus(scene, radius_px, depth_m);
        const Flux found =
            flux_of(RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0));
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(found.light[c] / exact.light[c], 1, 1e-4)
              << slant_deg << " deg, " << depth_m << " m, " << radius_px << " px, channel " << c;
        }
        printf("%4.0f %3.1f %5.2f  light %8.5f cover %8.5f sharp %8.5f %8.5f\n", slant_deg, depth_m, radius_px, found.light[0]/exact.light[0], found.coverage/exact.coverage, sharp.light[0]/exact.light[0], sharp.coverage/exact.coverage);
        worst = std::max(worst, std::abs(found.light[0] / exact.light[0] - 1));
        EXPECT_NEAR(found.coverage / exact.coverage, 1, 1e-4)
            << slant_deg << " deg, " << depth_m << " m, " << radius_px << " px";
      }
    }
  }
  printf("worst %g\n", worst);
}

// The exact composite through a real lens: the mean over `points` of its aperture, evenly spread
// (Vogel's spiral), the camera moved there, looking the same way. Each picture is moved by
// f a / s, such that what is in focus stays: for a focus at infinity by nothing, else the points are
// those for which it is a whole number of pixels.
Image lens_truth(const Scene& scene, const StreakAtlas& atlas, int points) {
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  const int width = scene.camera.width_px, height = scene.camera.height_px;
  const Image background = make_image(width, height, 3);
  Image depth_m = make_image(width, height, 1);
  std::fill(depth_m.values.begin(), depth_m.values.end(), std::numeric_limits<float>::infinity());
  const CameraFrame frame = camera_frame(scene.camera);
  const DepthOfField lens = *scene.camera.depth_of_field;
  struct Point {
    double x, y;  // in apertures' radii
    int shift_x, shift_y;
  };
  std::vector<Point> samples;
  if (std::isinf(lens.focus_m)) {
    for (int i = 0; i < points; ++i) {
      const double r = std::sqrt((i + 0.5) / points), turn = 2.399963229728653 * i;
      samples.push_back({r * std::cos(turn), r * std::sin(turn), 0, 0});
    }
  } else {
    const double most = frame.focal_px * lens.aperture_m / 2 / lens.focus_m;
    const int reach = static_cast<int>(most);
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (std::hypot(x, y) <= most) samples.push_back({x / most, y / most, x, y});
      }
    }
  }
  std::vector<double> sum(background.values.size());
  for (const Point& point : samples) {
    Scene moved = scene;
    const Eigen::Vector3d step =
        lens.aperture_m / 2 * (point.x * frame.right + point.y * frame.up);
    moved.camera.position_m += step;
    moved.camera.target_m += step;
    const Image rain =
        composite_frame(moved, atlas, drops, sky_of(scene, atlas, 0), background, depth_m).rain;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const int from_x = x - point.shift_x, from_y = y + point.shift_y;
        if (from_x < 0 || from_x >= width || from_y < 0 || from_y >= height) continue;
        for (int c = 0; c < 3; ++c)
          sum[static_cast<std::size_t>(3 * (y * width + x) + c)] +=
              static_cast<double>(rain.at(from_x, from_y, c));
      }
    }
  }
  Image mean = background;
  for (std::size_t i = 0; i < sum.size(); ++i)
    mean.values[i] = static_cast<float>(sum[i] / static_cast<double>(samples.size()));
  return mean;
}

double relative_rmse(const Image& found, const Image& expected) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < found.values.size(); ++i) {
    off += std::pow(static_cast<double>(found.values[i] - expected.values[i]), 2);
    all += std::pow(static_cast<double>(expected.values[i]), 2);
  }
  return std::sqrt(off / all);
}

// The exact composite at fine_px times the resolution, spread over a disc, row by row of it, and
// gathered into pixels.
Image disc_truth(Scene scene, const StreakAtlas& atlas, double radius_px, int fine_px) {
  const int width = scene.camera.width_px, height = scene.camera.height_px;
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  scene.camera.width_px *= fine_px;
  scene.camera.height_px *= fine_px;
  Image depth_m = make_image(width * fine_px, height * fine_px, 1);
  std::fill(depth_m.values.begin(), depth_m.values.end(), std::numeric_limits<float>::infinity());
  const Image fine =
      composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
                      make_image(width * fine_px, height * fine_px, 3), depth_m)
          .rain;
  const double radius = radius_px * fine_px;
  const int reach = static_cast<int>(radius);
  std::vector<double> sum(static_cast<std::size_t>(3 * width * height));
  std::vector<double> before(static_cast<std::size_t>(fine.width) + 1);
  double points = 0;
  for (int dy = -reach; dy <= reach; ++dy)
    points += 2 * std::floor(std::sqrt(radius * radius - dy * dy)) + 1;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < fine.height; ++y) {
      bool lit = false;
      for (int x = 0; x < fine.width; ++x) {
        const auto value = static_cast<double>(fine.at(x, y, c));
        before[static_cast<std::size_t>(x) + 1] = before[static_cast<std::size_t>(x)] + value;
        lit = lit || value != 0;
      }
      if (!lit) continue;
      for (int dy = -reach; dy <= reach; ++dy) {
        if (y + dy < 0 || y + dy >= fine.height) continue;
        const int half = static_cast<int>(std::sqrt(radius * radius - dy * dy));
        for (int x = 0; x < fine.width; ++x) {
          const auto low = static_cast<std::size_t>(std::max(0, x - half));
          const auto high = static_cast<std::size_t>(std::min(fine.width, x + half + 1));
          const int pixel = (y + dy) / fine_px * width + x / fine_px;
          sum[static_cast<std::size_t>(3 * pixel + c)] += before[high] - before[low];
        }
      }
    }
  }
  Image mean = make_image(width, height, 3);
  for (std::size_t i = 0; i < sum.size(); ++i)
    mean.values[i] = static_cast<float>(sum[i] / (points * fine_px * fine_px));
  return mean;
}

TEST(Lens, AStreakIsSpreadOverADisc) {
  PLUVIA_NEEDS_OPENGL();
  for (const double depth_m : {0.6, 3.0}) {
    for (const double slant_deg : {0.0, 11.0, 44.0, 90.0}) {
      for (const double radius_px : {0.15, 0.5, 1.0, 1.5, 4.3, 12.0, 25.0}) {
        Scene scene = one_streak(depth_m, slant_deg, depth_m < 1 ? 45 : 20);
        scene.camera.width_px = scene.camera.height_px = 160;
        const Image truth = disc_truth(scene, quarter_atlas(), radius_px, 8);
        const Image sharp =
            RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0).rain;
        const double s = relative_rmse(sharp, truth);
        defocus(scene, radius_px, depth_m);
        const Image quad =
            RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0).rain;
        const Image walked = RainRenderer(scene, quarter_atlas()).render(0).rain;
        printf("%3.1f m %2.0f deg %5.2f px  sharp %7.4f quad %7.4f  default %7.4f\n", depth_m, slant_deg,
               radius_px, s, relative_rmse(quad, truth), relative_rmse(walked, truth));
      }
    }
  }
}

TEST(Lens, AStreakOutOfFocusIsWhatATrueLensShows) {
  PLUVIA_NEEDS_OPENGL();
  for (const double depth_m : {0.6, 3.0}) {
    for (const double slant_deg : {0.0, 11.0, 44.0, 90.0}) {
      for (const double radius_px : {0.15, 0.5, 1.5, 4.3, 12.0}) {
        Scene scene = one_streak(depth_m, slant_deg, depth_m < 1 ? 45 : 20);
        scene.camera.width_px = scene.camera.height_px = 200;
        defocus(scene, radius_px, depth_m);
        const Image truth = lens_truth(scene, quarter_atlas(), radius_px > 4 ? 300 : 60);
        const Image quad =
            RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0).rain;
        const Image walked = RainRenderer(scene, quarter_atlas()).render(0).rain;
        printf("%3.1f m %2.0f deg %5.2f px  quad %7.4f  default %7.4f\n", depth_m, slant_deg,
               radius_px, relative_rmse(quad, truth), relative_rmse(walked, truth));
      }
    }
  }
}

}  // namespace
}  // namespace pluvia
