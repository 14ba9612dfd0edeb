// Splashes on the GPU: against raytrace/splash.h part by part, and what a picture makes of them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "raytrace/droplet_light.h"
#include "raytrace/splash_space.h"
#include "realtime/rain_renderer.h"
#include "tests/frame_light.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// A drop that hits the ground before the camera at 0.1 s.
Scene one_splash() {
  Scene scene = rainy_scene(0);
  scene.camera.position_m = {0, 0, 0.35};
  scene.camera.target_m = {0, 1, 0.1};
  scene.camera.exposure_s = 0.004;
  scene.drops = {{.centre_m = {0.02, 0.8, 0.849}}};
  scene.splashes.emplace();
  return scene;
}

double area_of(const std::vector<StrokeRecord>& strokes) {
  double area_px = 0;
  for (const StrokeRecord& stroke : strokes) area_px += static_cast<double>(stroke.area_px);
  return area_px;
}

Eigen::Vector2d seen_at(const Camera& camera, const Eigen::Vector3d& place_m) {
  const CameraFrame frame = camera_frame(camera);
  const Eigen::Vector3d c = place_m - camera.position_m;
  return {camera.width_px / 2.0 + frame.focal_px * c.dot(frame.right) / c.dot(frame.forward),
          camera.height_px / 2.0 - frame.focal_px * c.dot(frame.up) / c.dot(frame.forward)};
}

TEST(RealtimeSplash, EveryStrokeIsAPartOnItsPath) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.mesh = {};  // leans to the east
  add_rectangle(scene.mesh, {-3, -3, -0.9f}, {6, 0, 1.8f}, {0, 6, 0}, {});
  const RainSpace space = make_rain_space(scene);
  const SplashSpace splashes = make_splash_space(scene, space);
  const SplashTable& table = splashes.tables[0];
  RainRenderer renderer(scene, quarter_atlas());
  for (const double time_s : {0.102, 0.13, 0.2}) {
    const std::vector<Splash> field = splash_field(scene, space, splashes, time_s);
    ASSERT_EQ(field.size(), 1u);
    const Splash& splash = field[0];
    const SplashHit hit = {splash.normal, {0, 0, -8.49}, splash.turn_rad};
    const std::size_t first =
        static_cast<std::size_t>(splash.variant * (crown_beads + table.droplets));
    const int droplets = thrown_droplets(table, splash.variant, splash.normal.z());
    ASSERT_GT(droplets, 20);
    const auto strokes = renderer.splash_strokes(time_s);
    long expected = 0;
    for (int i = 0; i < droplets; ++i) {
      const SplashPart& part = table.parts[first + static_cast<std::size_t>(crown_beads + i)];
      const double step_s = 0.02, at_s = splash.since_s + 0.5 * scene.camera.exposure_s;
      // Whole exposures inside one step of the path, clear of launch and landing.
      if (std::floor(splash.since_s / step_s) !=
              std::floor((splash.since_s + scene.camera.exposure_s) / step_s) ||
          splash.since_s < part.delay_s)
        continue;
      const Eigen::Vector3d a = splash_place_m(table, part, hit, splash.since_s);
      const Eigen::Vector3d b =
          splash_place_m(table, part, hit, splash.since_s + scene.camera.exposure_s);
      if (!(a.dot(hit.normal) > 0 && b.dot(hit.normal) > 0)) continue;
      const Eigen::Vector2d middle = 0.5 * (seen_at(scene.camera, splash.place_m + a) +
                                            seen_at(scene.camera, splash.place_m + b));
      if (middle.x() < 2 || middle.x() > 158 || middle.y() < 2 || middle.y() > 118) continue;
      ++expected;
      const auto nearest = std::min_element(
          strokes.begin(), strokes.end(), [&](const StrokeRecord& s, const StrokeRecord& t) {
            const auto off = [&](const StrokeRecord& r) {
              return std::hypot(static_cast<double>(r.centre_px.x) - middle.x(),
                                static_cast<double>(r.centre_px.y) - middle.y());
            };
            return off(s) < off(t);
          });
      ASSERT_NE(nearest, strokes.end());
      // Floats: 1e-5 of the place in the picture and of the time since the hit.
      EXPECT_NEAR(static_cast<double>(nearest->centre_px.x), middle.x(), 5e-3) << at_s;
      EXPECT_NEAR(static_cast<double>(nearest->centre_px.y), middle.y(), 5e-3) << at_s;
    }
    EXPECT_GT(expected, time_s < 0.11 ? 2 : 5) << time_s;
    EXPECT_GE(static_cast<long>(strokes.size()), expected);
  }
}

// What a splash covers while the shutter is open, in pixels, by 40 moments of it.
double area_px(const Scene& scene, const SplashTable& table, const Splash& splash,
               const Eigen::Vector3d& velocity_m_s) {
  const CameraFrame frame = camera_frame(scene.camera);
  const SplashHit hit = {splash.normal, velocity_m_s, splash.turn_rad};
  const double cosine = -splash.normal.dot(velocity_m_s) / table.speed_m_s;
  const int droplets = thrown_droplets(table, splash.variant, cosine);
  const auto first = static_cast<std::size_t>(splash.variant * (crown_beads + table.droplets));
  double sum = 0;
  for (int i = 0; droplets > 0 && i < crown_beads + droplets; ++i) {
    const SplashPart& part = table.parts[first + static_cast<std::size_t>(i)];
    for (int moment = 0; moment < 40; ++moment) {
      const double time_s = splash.since_s + (moment + 0.5) / 40 * scene.camera.exposure_s;
      const Eigen::Vector3d place = splash_place_m(table, part, hit, time_s);
      if (!(time_s > part.delay_s && place.dot(splash.normal) > 0)) continue;
      const double depth_m = (splash.place_m + place - scene.camera.position_m).dot(frame.forward);
      sum += pi * std::pow(part.radius_m * frame.focal_px / depth_m, 2) / 40;
    }
  }
  return sum;
}

TEST(RealtimeSplash, ThePictureHasAllSplashesOfTheField) {
  PLUVIA_NEEDS_OPENGL();
  for (const Eigen::Vector3d& velocity : {Eigen::Vector3d(0, 0, -8.49), {4, -2, -8}}) {
    Scene scene = rainy_scene(0);
    scene.mesh = {};  // leans, and stands out of the box to the east
    add_rectangle(scene.mesh, {-3, -3, -1}, {6, 0, 2}, {0, 6, 0}, {});
    scene.rain.sizes = {{.r0_m = 1.6e-3, .drops_per_m3 = 60, .velocity_m_s = velocity},
                        {.r0_m = 0.9e-3, .drops_per_m3 = 60, .velocity_m_s = 0.8 * velocity}};
    scene.rain.box_min_m = {-0.3, -0.3, -0.5}, scene.rain.box_max_m = {0.3, 0.3, 0.05};
    scene.rain.culling_radius_m = 5;
    scene.rain.local_height_m = 0.5;
    scene.camera.position_m = {0, -3, 1};
    scene.camera.target_m = {0, 0, 0.1};
    // So near and fine that every droplet is drawn, and all are in the picture.
    scene.camera.width_px = 640, scene.camera.height_px = 480;
    // It rains on the western half, and a little on the rest.
    scene.rain.density = {.width = 2,
                          .height = 1,
                          .share = {1, 0.3f},
                          .min_m = {-0.3, -0.3},
                          .max_m = {0.3, 0.3},
                          .height_m = 0.05};
    sum_density(scene.rain.density);
    scene.splashes.emplace();
    const RainSpace space = make_rain_space(scene);
    const SplashSpace splashes = make_splash_space(scene, space);
    RainRenderer renderer(scene, quarter_atlas());
    for (const double time_s : {0.4, 10.01, 3600.2}) {
      double expected = 0;
      const auto field = splash_field(scene, space, splashes, time_s);
      ASSERT_GT(field.size(), 20u);
      for (const Splash& splash : field) {
        const auto size = static_cast<std::size_t>(splash.size);
        expected +=
            area_px(scene, splashes.tables[size], splash, scene.rain.sizes[size].velocity_m_s);
      }
      // Launches and landings to a fortieth of the exposure, and paths cut straight.
      EXPECT_NEAR(area_of(renderer.splash_strokes(time_s)) / expected, 1, 0.01)
          << velocity.transpose() << " at " << time_s;
    }
  }
}

TEST(RealtimeSplash, PixelsHoldExactlyTheAreaOfTheStrokes) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.camera.position_m = {0, -1, 0.5};  // all of it in the picture
  scene.camera.target_m = {0, 0.8, 0.2};
  RainRenderer renderer(scene, quarter_atlas());
  for (const double time_s : {0.11, 0.15, 0.25}) {
    const auto strokes = renderer.splash_strokes(time_s);
    ASSERT_FALSE(strokes.empty());
    const Frame frame = renderer.render(time_s);
    double expected_light = 0;
    for (const StrokeRecord& stroke : strokes)
      expected_light += static_cast<double>(stroke.area_px * stroke.radiance.x);
    // Strokes over each other hide each other: second order in a coverage of a few hundredths.
    EXPECT_NEAR(covered(frame) / area_of(strokes), 1, 0.02) << time_s;
    EXPECT_NEAR(light(frame, 0) / expected_light, 1, 0.03) << time_s;
  }
}

TEST(RealtimeSplash, LightIsThatOfWaterSpheres) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.lights = {Light{.name = "sun", .kind = LightKind::sun}};
  scene.lights[0].illuminance_lux = {100, 50, 0};
  scene.environment.uniform_cd_m2 = {0, 0, 2};
  const std::vector<double> phase = droplet_phase(360);
  for (const Eigen::Vector3d& way : {Eigen::Vector3d(0, -1, -0.3), {0, 1, -0.3}, {1, 0, -0.5}}) {
    scene.lights[0].direction = way.normalized();
    const auto strokes = RainRenderer(scene, quarter_atlas()).splash_strokes(0.16);
    ASSERT_GT(strokes.size(), 10u);
    for (const StrokeRecord& stroke : strokes) {
      const CameraFrame frame = camera_frame(scene.camera);
      const Eigen::Vector3d seen =
          (frame.focal_px * frame.forward +
           (static_cast<double>(stroke.centre_px.x) - scene.camera.width_px / 2.0) * frame.right -
           (static_cast<double>(stroke.centre_px.y) - scene.camera.height_px / 2.0) * frame.up)
              .normalized();
      const double place = std::acos(-seen.dot(scene.lights[0].direction)) / pi * 360 - 0.5;
      const auto low = static_cast<std::size_t>(place);
      const double share = place - std::floor(place);
      const double per_sr = (1 - share) * phase[low] + share * phase[low + 1];
      // A stroke's middle in the picture is not quite its middle in the world; a rainbow is steep.
      EXPECT_NEAR(static_cast<double>(stroke.radiance.x), 100 * per_sr, 2 * per_sr + 0.02);
      EXPECT_NEAR(static_cast<double>(stroke.radiance.y), 50 * per_sr, 1 * per_sr + 0.01);
      EXPECT_FLOAT_EQ(stroke.radiance.z, 2);
    }
  }
}

TEST(RealtimeSplash, FogDimsItsLightAndAWallShadesIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.lights = {{.name = "lamp", .position_m = {0, 4, 1}, .intensity_cd = {50, 50, 50}}};
  scene.environment.uniform_cd_m2 = {0, 0, 0};
  const auto strokes_of = [&] { return RainRenderer(scene, quarter_atlas()).splash_strokes(0.15); };
  const auto clear = strokes_of();
  ASSERT_GT(clear.size(), 20u);
  scene.fog = Fog{.extinction_per_m = 0.5};
  const auto dimmed = strokes_of();
  ASSERT_EQ(dimmed.size(), clear.size());
  for (std::size_t i = 0; i < clear.size(); ++i) {
    EXPECT_GT(clear[i].radiance.x, 0);
    // Droplets are 0.4 to 1.3 m away.
    EXPECT_LT(dimmed[i].radiance.x, std::exp(-0.5f * 0.4f) * clear[i].radiance.x);
    EXPECT_GT(dimmed[i].radiance.x, std::exp(-0.5f * 1.3f) * clear[i].radiance.x);
  }
  scene.fog.reset();
  add_rectangle(scene.mesh, {-3, 2.5, 0}, {6, 0, 0}, {0, 0, 3}, {});
  for (const bool shadow : {false, true}) {
    scene.lights[0].shadow = shadow;
    const auto behind = strokes_of();
    ASSERT_EQ(behind.size(), clear.size());
    for (const StrokeRecord& stroke : behind) EXPECT_EQ(stroke.radiance.x > 0, !shadow);
  }
}

TEST(RealtimeSplash, ExposuresAddUpFromATenthOfAMillisecondToASecond) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  // A fast small drop: the rain refuses exposures in which a drop falls less than its diameter.
  scene.drops = {{.centre_m = {0.02, 0.8, 2}, .r0_m = 0.7e-3, .velocity_m_s = {0, 0, -20}}};
  scene.camera.position_m.y() = -1;
  const auto seconds_px = [&](double exposure_s, double from_s, double to_s) {
    scene.camera.exposure_s = exposure_s;
    RainRenderer renderer(scene, quarter_atlas());
    double sum = 0;
    const auto frames = std::lround((to_s - from_s) / exposure_s);
    for (long i = 0; i < frames; ++i) {
      const auto strokes = renderer.splash_strokes(from_s + static_cast<double>(i) * exposure_s);
      for (const StrokeRecord& stroke : strokes) {
        EXPECT_TRUE(std::isfinite(stroke.area_px) && std::isfinite(stroke.half_axis_px.x) &&
                    std::isfinite(stroke.radiance.x) && stroke.area_px >= 0 &&
                    std::abs(stroke.half_axis_px.x) + std::abs(stroke.half_axis_px.y) > 0);
      }
      sum += exposure_s * area_of(strokes);
    }
    return sum;
  };
  // One second holds the whole splash; from 1 ms before the hit. Steps end elsewhere with each
  // exposure, and so does the depth at which a stroke is measured: 1 %.
  const double whole = seconds_px(1, 0.099, 1.099);
  EXPECT_GT(whole, 0);
  for (const double exposure_s : {0.1, 0.02, 0.005})
    EXPECT_NEAR(seconds_px(exposure_s, 0.099, 1.099) / whole, 1, 0.01) << exposure_s;
  EXPECT_NEAR(seconds_px(1e-4, 0.120, 0.125) / seconds_px(5e-3, 0.120, 0.125), 1, 0.01);
}

TEST(RealtimeSplash, FarSplashesKeepTheirArea) {
  PLUVIA_NEEDS_OPENGL();
  // The same hits from 8 and from 64 m: the area in the picture falls with the square of the
  // distance, though far away a few droplets stand for all.
  const auto area_from = [](double distance_m, std::size_t& strokes) {
    Scene scene = rainy_scene(9000);
    scene.splashes.emplace();
    scene.rain.box_min_m = {-2, -2, 0}, scene.rain.box_max_m = {2, 2, 4};
    scene.rain.culling_radius_m = 80;
    scene.rain.local_height_m = 4;
    scene.camera.position_m = {0, -distance_m, 1};
    scene.camera.target_m = {0, 0, 0.5};
    scene.camera.vertical_fov_deg = 60;
    scene.camera.width_px = 1280, scene.camera.height_px = 960;
    RainRenderer renderer(scene, quarter_atlas());
    double sum = 0;
    for (const double time_s : {0.5, 1.5, 2.5}) {
      const auto records = renderer.splash_strokes(time_s);
      strokes += records.size();
      sum += area_of(records) * distance_m * distance_m;
    }
    return sum;
  };
  std::size_t near_strokes = 0, far_strokes = 0;
  const double near = area_from(8, near_strokes), far = area_from(64, far_strokes);
  EXPECT_GT(far, 0);
  EXPECT_LT(far_strokes, near_strokes / 8) << "the point of it";
  // Perspective within the 4 m: 1 / (8 +- 2)^2 has a mean 6 % above 1 / 64. Which droplets are in
  // the air differs: 1,000 splashes, of which one droplet each may be up or down.
  EXPECT_NEAR(near / far, 1.06, 3 / std::sqrt(1000.0));
}

TEST(RealtimeSplash, SurfacesHideIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.camera.position_m.y() = -1;
  const auto light = [&] {
    const Frame frame = RainRenderer(scene, quarter_atlas()).render(0.15);
    double sum = 0;
    for (const float value : frame.rain.values) sum += static_cast<double>(value);
    return sum;
  };
  EXPECT_GT(light(), 0);
  // A wall between camera and splash, which no drop meets from above.
  add_rectangle(scene.mesh, {-3, 0, 0}, {6, 0, 0}, {0, 0, 2}, {});
  EXPECT_EQ(light(), 0);
}

const PlannedPass* pass_of(const FramePlan& plan, const std::string& name) {
  for (const PlannedPass& pass : plan.passes) {
    if (pass.name == name) return &pass;
  }
  return nullptr;
}

TEST(RealtimeSplash, ContributesNothingWhereTheSceneDoesNotNameIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(200);
  RainRenderer plain(scene, quarter_atlas());
  scene.splashes.emplace();
  RainRenderer splashing(scene, quarter_atlas());
  const FramePlan without = plain.plan(), with = splashing.plan();
  EXPECT_EQ(pass_of(without, "splashes"), nullptr);
  ASSERT_NE(pass_of(with, "splashes"), nullptr);
  EXPECT_GT(bytes_of(*pass_of(with, "splashes")), 0u);
  ASSERT_EQ(with.passes.size(), without.passes.size() + 1);
  for (const PlannedPass& pass : without.passes) {
    const PlannedPass* same = pass_of(with, pass.name);
    ASSERT_TRUE(same) << pass.name;
    EXPECT_EQ(bytes_of(*same), bytes_of(pass)) << pass.name;
    EXPECT_EQ(same->shaders, pass.shaders) << pass.name;
    for (const std::string& file : pass.shaders)
      EXPECT_EQ(file.find("splash"), std::string::npos) << file;
  }
  EXPECT_EQ(plain.render(1).costs.size() + 1, splashing.render(1).costs.size());
  // Dry: nothing that could splash, and no pass.
  scene.rain.sizes.clear();
  EXPECT_EQ(pass_of(RainRenderer(scene, quarter_atlas()).plan(), "splashes"), nullptr);
}

TEST(RealtimeSplash, IsSkippedAndSaysSoWhereNoneIsInView) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  RainRenderer renderer(scene, quarter_atlas());
  const auto cost_at = [&](double time_s) {
    const Frame frame = renderer.render(time_s);
    for (const PassCost& cost : frame.costs) {
      if (cost.pass == "splashes") return cost.skipped;
    }
    return std::string("no such pass");
  };
  EXPECT_EQ(cost_at(0.05), "no splash in view") << "before the hit";
  EXPECT_EQ(cost_at(0.12), "");
  EXPECT_EQ(cost_at(1.5), "no splash in view") << "long after it";
  EXPECT_EQ(renderer.render(0.05).splash_strokes, 0);
  EXPECT_GT(renderer.render(0.12).splash_strokes, 20);
}

// tests/golden/splash.exr: crown and droplets 15 ms after the hit, for somebody to look at when it
// changes. What is found is written beside the temporary files.
TEST(RealtimeSplash, LooksAsItDid) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_splash();
  scene.camera.position_m = {0, 0.4, 0.15};
  scene.camera.target_m = {0.02, 0.8, 0.03};
  scene.camera.width_px = 96, scene.camera.height_px = 72;
  const Image found = RainRenderer(scene, quarter_atlas()).render(0.115).rain;
  const std::string file = testing::TempDir() + "pluvia_splash.exr";
  write_exr(file, found);
  const Image golden = read_image(PLUVIA_SOURCE_DIR "/tests/golden/splash.exr");
  ASSERT_EQ(found.values.size(), golden.values.size());
  double off = 0, all = 0;
  for (std::size_t i = 0; i < found.values.size(); ++i) {
    off += std::pow(static_cast<double>(found.values[i] - golden.values[i]), 2);
    all += std::pow(static_cast<double>(golden.values[i]), 2);
  }
  // Another processor's exp, acos and projection may move a stroke, thinner than a pixel, by 5e-3
  // px (the bound of EveryStrokeIsAPartOnItsPath): so much of its light goes to the next pixel.
  EXPECT_LT(std::sqrt(off / all), 1e-2) << file;
}

TEST(RealtimeSplash, AFrameHasTheSameBytesAgain) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(800);
  scene.splashes.emplace();
  scene.camera.target_m = {1, 5, 0};
  const Frame first = RainRenderer(scene, quarter_atlas()).render(3);
  RainRenderer renderer(scene, quarter_atlas());
  renderer.render(1);
  const Frame again = renderer.render(3);
  EXPECT_GT(first.splash_strokes, 100);
  EXPECT_TRUE(first.color.values == again.color.values);
  EXPECT_TRUE(all_finite(first.color));
}

}  // namespace
}  // namespace pluvia
