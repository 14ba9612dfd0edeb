// Streaks out of focus (raytrace/depth_of_field.h, realtime/shaders/rain_defocus.glsl).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "raytrace/depth_of_field.h"
#include "raytrace/drop_field.h"
#include "raytrace/rain_space.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "validate/frame_composite.h"
#include "validate/metrics.h"

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
  scene.drops = {{.centre_m = middle - velocity / 120, .velocity_m_s = velocity, .oscillation = 3}};
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

// Sums of up to 2,000 floats of 24 bits, each from a difference of two sums that are some 100 times
// as large: 2^-24 100 / sqrt(2000) of the whole, and what the composite rounds.
constexpr double rounding = 2e-5;

TEST(Lens, NoLightIsLostOrMade) {
  PLUVIA_NEEDS_OPENGL();
  for (const double slant_deg : {0.0, 11.0, 44.0, 90.0}) {
    for (const double depth_m : {0.6, 3.0}) {
      const Scene sharp = one_streak(depth_m, slant_deg, depth_m < 1 ? 45 : 20);
      const Flux exact = exact_flux(sharp, quarter_atlas());
      for (const double radius_px : {0.15, 1.5, 21.0, 60.0}) {
        Scene scene = sharp;
        defocus(scene, radius_px, depth_m);
        const Flux found =
            flux_of(RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0));
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(found.light[c] / exact.light[c], 1, rounding)
              << slant_deg << " deg, " << depth_m << " m, " << radius_px << " px, channel " << c;
        EXPECT_NEAR(found.coverage / exact.coverage, 1, rounding)
            << slant_deg << " deg, " << depth_m << " m, " << radius_px << " px";
      }
    }
  }
}

TEST(Lens, AThinStreakThatIsWalkedLosesNothingEither) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_streak(3, 11);
  scene.camera.vertical_fov_deg = 40;
  const Flux exact = exact_flux(scene, quarter_atlas());
  defocus(scene, 0.45, 3);
  RainRenderer renderer(scene, quarter_atlas());
  ASSERT_EQ(renderer.streak_records(0).streaks.size(), 0u);
  const Flux found = flux_of(renderer.render(0));
  // Two steps in a pixel hide each other (rain_splat.comp): 0.4 % at most.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.light[c] / exact.light[c], 1, 4e-3);
  EXPECT_NEAR(found.coverage / exact.coverage, 1, 4e-3);
}

// The exact composite through a real lens: the mean over `points` of its aperture, evenly spread
// (Vogel's spiral), the camera moved there, looking the same way. Each picture is moved by
// f a / s, such that what is in focus stays: for a focus at infinity by nothing, else the points
// are those for which it is a whole number of pixels.
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
    const Eigen::Vector3d step = lens.aperture_m / 2 * (point.x * frame.right + point.y * frame.up);
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

// The exact composite at fine_px times the resolution, spread over a disc, row by row of it, and
// gathered into pixels.
Image disc_truth(Scene scene, const StreakAtlas& atlas, double radius_px, int fine_px) {
  const int width = scene.camera.width_px, height = scene.camera.height_px;
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  scene.camera.width_px *= fine_px;
  scene.camera.height_px *= fine_px;
  Image depth_m = make_image(width * fine_px, height * fine_px, 1);
  std::fill(depth_m.values.begin(), depth_m.values.end(), std::numeric_limits<float>::infinity());
  const Image fine = composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
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

// What is left: the bars, whose ends show at the ends of streaks and glints (N = 1.5 Q + 1 of them:
// a share 1 / (pi N) of the disc lies up to a bar's width wrong, over 2 R of the streak's length:
// 0.02 at most), the truth's own eighths of a pixel (0.01), and the pixel, which is sheared along
// with a slanted streak: matched in variance, but not in shape, where it is most of the circle.
TEST(Lens, AStreakIsSpreadOverADisc) {
  PLUVIA_NEEDS_OPENGL();
  for (const double depth_m : {0.6, 3.0}) {
    for (const double slant_deg : {0.0, 11.0, 44.0, 90.0}) {
      for (const double radius_px : {0.6, 4.3, 25.0}) {
        Scene scene = one_streak(depth_m, slant_deg, depth_m < 1 ? 45 : 20);
        scene.camera.width_px = scene.camera.height_px = 160;
        const Image truth = disc_truth(scene, quarter_atlas(), radius_px, 8);
        defocus(scene, radius_px, depth_m);
        const Image found = RainRenderer(scene, quarter_atlas()).render(0).rain;
        const bool sheared = slant_deg == 44;
        EXPECT_LT(relative_rmse(found, truth), sheared ? 0.07 : 0.03)
            << slant_deg << " deg, " << depth_m << " m, " << radius_px << " px";
      }
    }
  }
}

// Before, at and behind the distance of focus, and for one at infinity. Aperture small beside the
// distances: from all over it a streak looks alike (0.2 degrees), which the effect takes for
// granted. Beside the bounds above, the lens has a few hundred points.
TEST(Lens, ATrueLensShowsTheSame) {
  PLUVIA_NEEDS_OPENGL();
  struct Case {
    double depth_m, focus_m, scale_px;  // f A / 2 / the distance of focus, or of the drop
  };
  for (const Case& c : {Case{2, 4, 8.3}, {6, 3, 9.2}, {3, infinity, 6}, {3, 3, 4.1}}) {
    Scene scene = one_streak(c.depth_m, 11, 5);
    scene.camera.width_px = scene.camera.height_px = 160;
    scene.camera.exposure_s = 1.0 / 250;  // a short streak, all in the picture
    scene.camera.vertical_fov_deg = 5;
    const double focal_px = camera_frame(scene.camera).focal_px;
    const double unit_m = std::min(c.focus_m, c.focus_m < 1e9 ? c.focus_m : c.depth_m);
    scene.camera.depth_of_field =
        DepthOfField{.aperture_m = 2 * c.scale_px * unit_m / focal_px, .focus_m = c.focus_m};
    const Image truth = lens_truth(scene, quarter_atlas(), 200);
    const Image found = RainRenderer(scene, quarter_atlas()).render(0).rain;
    EXPECT_LT(relative_rmse(found, truth), 0.05) << c.depth_m << " m, focus " << c.focus_m << " m";
    // Seen sharp it is nothing like it.
    if (c.depth_m != c.focus_m) {
      scene.camera.depth_of_field.reset();
      EXPECT_GT(relative_rmse(RainRenderer(scene, quarter_atlas()).render(0).rain, truth), 0.5);
    }
  }
}

Scene lens_shower() {
  Scene scene = rainy_scene(3000);
  scene.camera.width_px = 96;
  scene.camera.height_px = 72;
  scene.splashes = Splashes{};
  return scene;
}

TEST(Lens, APinholeIsTheSameBytesAndTheSamePlan) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = lens_shower();
  RainRenderer sharp(scene, quarter_atlas());
  const Frame expected = sharp.render(0.5);
  const FramePlan plan = sharp.plan();
  for (const double aperture_m : {0.0, 1e-6}) {  // 1e-6: no circle that can be seen
    scene.camera.depth_of_field = DepthOfField{.aperture_m = aperture_m, .focus_m = 3};
    RainRenderer renderer(scene, quarter_atlas());
    EXPECT_EQ(renderer.render(0.5).color.values, expected.color.values);
    const FramePlan same = renderer.plan();
    ASSERT_EQ(same.passes.size(), plan.passes.size());
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
      EXPECT_EQ(bytes_of(same.passes[i]), bytes_of(plan.passes[i])) << plan.passes[i].name;
      EXPECT_EQ(same.passes[i].shaders, plan.passes[i].shaders);
    }
    EXPECT_NE(plan_text(same).find("nothing to see"), std::string::npos);
  }
  scene.camera.depth_of_field->aperture_m = 0.02;
  RainRenderer lens(scene, quarter_atlas());
  const Frame frame = lens.render(0.5);
  const FramePlan with = lens.plan();
  ASSERT_EQ(with.passes.size(), plan.passes.size());
  for (std::size_t i = 0; i < plan.passes.size(); ++i) {
    if (plan.passes[i].name != "surfaces" && plan.passes[i].name != "composite") continue;
    EXPECT_EQ(bytes_of(with.passes[i]), bytes_of(plan.passes[i])) << plan.passes[i].name;
    EXPECT_EQ(with.passes[i].shaders, plan.passes[i].shaders);
  }
  EXPECT_EQ(frame.background.values, expected.background.values) << "surfaces stay sharp";
  EXPECT_NE(frame.color.values, expected.color.values);
}

TEST(Lens, NoShaderHasCodeOfItWithoutIt) {
  const std::string folder = PLUVIA_SOURCE_DIR "/realtime/shaders";
  int guarded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name == "rain_lens.glsl" || name == "rain_defocus.glsl") continue;  // included in guards
    std::ifstream file(entry.path());
    int depth = 0, lens_at = 0;  // of conditions; of that of the lens
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("#if")) ++depth;
      if (line == "#if LENS") lens_at = depth, ++guarded;
      const std::string code = line.substr(0, line.find("//"));
      const bool own = code.find("lens") != std::string::npos ||
                       code.find("circle") != std::string::npos ||
                       code.find("defocus") != std::string::npos;
      EXPECT_TRUE(!own || lens_at > 0) << name << ": " << line;
      if (line == "#endif" && depth-- == lens_at) lens_at = 0;
    }
  }
  EXPECT_GT(guarded, 5);
}

TEST(Lens, AStreakInFocusIsTheSameBytes) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_streak(3, 11);
  const Frame expected = RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0);
  scene.camera.depth_of_field = DepthOfField{.aperture_m = 0.1, .focus_m = 3};
  const Frame frame = RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 0}).render(0);
  EXPECT_EQ(frame.rain.values, expected.rain.values);
}

TEST(Lens, EverySchemeOfPacketsGivesTheSameBytes) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = lens_shower();
  scene.rain.sizes[0].drops_per_m3 /= 10;
  for (const DepthOfField& lens :
       {DepthOfField{0.03, 2}, DepthOfField{0.2}, DepthOfField{1, 0.1}}) {
    scene.camera.depth_of_field = lens;
    const auto frame = [&](PacketScheme scheme) {
      return RainRenderer(scene, quarter_atlas(), {.packets = {.scheme = scheme, .most_drops = 5}})
          .render(0.5);
    };
    const Frame world = frame(PacketScheme::world);
    for (const Image* image : {&world.color, &world.rain, &world.rain_tau})
      EXPECT_TRUE(all_finite(*image)) << lens.aperture_m;
    for (const PacketScheme scheme : {PacketScheme::tree, PacketScheme::grid}) {
      const Frame other = frame(scheme);
      EXPECT_EQ(other.streaks_in_view, world.streaks_in_view) << lens.aperture_m;
      EXPECT_EQ(other.color.values, world.color.values) << lens.aperture_m;
    }
  }
}

// Beside the picture, where a pinhole sees none of it, and as near as streaks are drawn: half of a
// circle of 150 px still falls into the picture.
TEST(Lens, ACircleReachesIntoThePictureFromBesideIt) {
  PLUVIA_NEEDS_OPENGL();
  for (const double aside_px : {-60.0, 60.0}) {
    Scene scene = one_streak(0.11, 0, 40);
    scene.camera.width_px = scene.camera.height_px = 100;
    scene.camera.exposure_s = 1.0 / 2000;
    const double focal_px = camera_frame(scene.camera).focal_px;
    scene.drops[0].centre_m.x() = (aside_px + (aside_px > 0 ? 50 : -50)) * 0.11 / focal_px;
    scene.drops[0].centre_m.z() = 1.6;
    EXPECT_EQ(RainRenderer(scene, quarter_atlas()).render(0).streaks_in_view, 0);
    defocus(scene, 150, 0.11);
    const Frame frame = RainRenderer(scene, quarter_atlas()).render(0);
    EXPECT_EQ(frame.streaks_in_view, 1);
    EXPECT_TRUE(all_finite(frame.color));
    const int near_column = aside_px > 0 ? 99 : 0;
    EXPECT_GT(frame.rain.at(near_column, 50, 1), 0);
  }
}

TEST(Lens, WhatIsOnTheCamerasPlaneIsNotDrawn) {
  PLUVIA_NEEDS_OPENGL();
  for (const double depth_m : {-1.0, 0.0, 1e-9, 0.0999}) {
    Scene scene = one_streak(3, 0);
    scene.drops[0].centre_m.y() = depth_m;
    scene.camera.depth_of_field = DepthOfField{.aperture_m = 1, .focus_m = 0.1};
    const Frame frame = RainRenderer(scene, quarter_atlas()).render(0);
    EXPECT_EQ(frame.streaks_in_view, 0) << depth_m;
    EXPECT_TRUE(all_finite(frame.color));
  }
}

TEST(Lens, ASplashOutOfFocusKeepsItsLight) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.camera.position_m = {0, -2, 0.4};
  scene.camera.target_m = {0, 0, 0.05};
  scene.camera.vertical_fov_deg = 25;
  scene.drops = {{.centre_m = {0, 0, 0.1}}};
  scene.splashes = Splashes{};
  RainRenderer sharp(scene, quarter_atlas());
  const Frame expected = sharp.render(0.03);
  defocus(scene, 3, 2);
  RainRenderer renderer(scene, quarter_atlas());
  const Frame frame = renderer.render(0.03);
  ASSERT_GT(frame.splash_strokes, 10);
  EXPECT_EQ(frame.splash_strokes, expected.splash_strokes);
  // Floats of many strokes; strokes over each other hide each other less when they are spread.
  const Flux before = flux_of(expected), after = flux_of(frame);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(after.light[c] / before.light[c], 1, 0.01);
  EXPECT_NE(frame.rain.values, expected.rain.values);
}

}  // namespace
}  // namespace pluvia
