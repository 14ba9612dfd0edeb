// Scenes that break renderers: each drawn and looked at for what must hold, or refused with a
// reason.
#include <cmath>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "realtime/shader.h"
#include "tests/realtime_fixture.h"
#include "tests/scene_files.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

Frame draw(const Scene& scene, const RenderOptions& options = {}) {
  RainRenderer renderer(scene, quarter_atlas(), options);
  return renderer.render(0.4);
}

void expect_sound(const Frame& frame) {
  EXPECT_TRUE(all_finite(frame.color));
  EXPECT_TRUE(all_finite(frame.rain));
  EXPECT_TRUE(all_finite(frame.rain_tau));
  for (const float value : frame.color.values) ASSERT_GE(value, 0);
  for (const float tau : frame.rain_tau.values) ASSERT_GE(tau, 0);
}

double sum_of(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(value);
  return sum;
}

TEST(HardScene, TheCameraStandsInADropsPath) {
  PLUVIA_NEEDS_OPENGL();
  // Drops that fall onto the lens, past it and behind it; looking level, up and down the fall.
  for (const Eigen::Vector3d& view :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)}) {
    for (const double off_m : {0.0, 1e-4, 0.02, 0.11}) {
      Scene scene = rainy_scene(0);
      scene.camera.target_m = scene.camera.position_m + view;
      for (const double up_m : {-0.2, 0.05, 0.07, 0.2, 1.0})
        scene.drops.push_back({.centre_m = scene.camera.position_m +
                                           Eigen::Vector3d(0, off_m, up_m) -
                                           0.4 * SingleDrop().velocity_m_s});
      expect_sound(draw(scene));
    }
  }
}

TEST(HardScene, LookingExactlyAlongTheFallADropIsAPoint) {
  PLUVIA_NEEDS_OPENGL();
  for (const double way : {1.0, -1.0}) {
    Scene scene = rainy_scene(0);
    scene.mesh = {};
    scene.camera.target_m = scene.camera.position_m + Eigen::Vector3d(0, 0, way);
    scene.drops = {{.centre_m = scene.camera.position_m + Eigen::Vector3d(0, 0, 3 * way) -
                                0.4 * SingleDrop().velocity_m_s}};
    const Frame frame = draw(scene);
    expect_sound(frame);
    EXPECT_EQ(frame.streaks_in_view, 1);
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const bool near = std::abs(x - 79.5) < 3 && std::abs(y - 59.5) < 3;
        EXPECT_TRUE(near || frame.rain_tau.at(x, y) == 0) << x << ", " << y;
      }
    }
    EXPECT_GT(sum_of(frame.rain_tau), 0);
  }
}

TEST(HardScene, ALongExposureBlursRainAndKeepsItsOpticalDepth) {
  PLUVIA_NEEDS_OPENGL();
  // Drops that cross the picture: in 1 s sixty times as many pass as stand in it in 1/60 s, each
  // for a sixtieth of the time.
  Scene scene = rainy_scene(20000);
  scene.mesh = {};
  scene.camera.target_m = scene.camera.position_m + Eigen::Vector3d(0, 1, 0);
  scene.rain.box_min_m.z() = -40;  // no drop leaves the box while it is in view
  scene.rain.box_max_m.z() = 40;
  scene.rain.local_height_m = 60;
  scene.rain.sizes[0].drops_per_m3 = 2;
  scene.camera.exposure_s = 1;
  const Frame blurred = draw(scene);
  expect_sound(blurred);
  scene.camera.exposure_s = 1.0 / 60;
  RainRenderer renderer(scene, quarter_atlas());
  double sharp = 0;
  constexpr int frames = 60;
  for (int k = 0; k < frames; ++k)
    sharp += sum_of(renderer.render(0.4 + k / 60.0).rain_tau) / frames;
  // The same drops over the same second; but a picture of one drop that covers a pixel for all of
  // its time is deeper than its sixtieth: the logarithm of what is left.
  EXPECT_NEAR(sum_of(blurred.rain_tau) / sharp, 1, 0.02);
}

TEST(HardScene, ALampInTheRainACentimetreFromDropsIsFinite) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.lights = {{"in the rain", {0.8, 3, 2}, {5000, 5000, 5000}}};
  const double fallen_m = 8.49 * (0.4 + 1.0 / 120);
  for (const double off_m : {0.01, -0.01, 0.002})
    scene.drops.push_back({.centre_m = {0.8 + off_m, 3, 2 + fallen_m}});
  const Frame frame = draw(scene);
  expect_sound(frame);
  EXPECT_EQ(frame.streaks_in_view, 3);
  EXPECT_GT(sum_of(frame.rain), 0);
}

TEST(HardScene, ALampBehindTheObserverLightsDropsByTheirReflection) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(3000);
  scene.environment = {};
  scene.lights = {{"behind", {0.3, -6, 2}, {900, 900, 900}}};
  const Frame frame = draw(scene);
  expect_sound(frame);
  EXPECT_GT(sum_of(frame.rain), 0);
}

TEST(HardScene, NoRainNoSurfaceNoLightIsTheSkyAlone) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene;
  scene.camera.width_px = 40;
  scene.camera.height_px = 30;
  scene.environment.uniform_cd_m2 = {1, 2, 3};
  const Frame frame = RainRenderer(scene, StreakAtlas{}).render(0);
  for (std::size_t i = 0; i < frame.color.values.size(); ++i)
    ASSERT_EQ(frame.color.values[i], static_cast<float>(1 + i % 3));
  scene.environment = {};
  EXPECT_EQ(sum_of(RainRenderer(scene, StreakAtlas{}).render(0).color), 0);
}

TEST(HardScene, ABlackDensityMapIsADryFrameAndAWhiteOneIsAnyRain) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(3000);
  const Frame open = draw(scene);
  DensityMap& map = scene.rain.density;
  for (const int side : {1, 8}) {
    for (const float share : {0.0f, 1.0f}) {
      map = {.width = side,
             .height = side,
             .share = std::vector<float>(static_cast<std::size_t>(side * side), share),
             .min_m = scene.rain.box_min_m.head<2>(),
             .max_m = scene.rain.box_max_m.head<2>(),
             .height_m = scene.rain.box_max_m.z()};
      sum_density(map);
      const Frame frame = draw(scene);
      if (share == 0)
        EXPECT_EQ(frame.color.values, frame.background.values) << side;
      else
        EXPECT_EQ(frame.color.values, open.color.values) << side;
    }
  }
}

TEST(HardScene, UnderOneWhitePixelItRainsThereAlone) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(60000);
  scene.camera.target_m = scene.camera.position_m + Eigen::Vector3d(0, 1, 0);
  const Eigen::Vector2d low = scene.rain.box_min_m.head<2>(), high = scene.rain.box_max_m.head<2>();
  scene.rain.density = {.width = 8,
                        .height = 8,
                        .share = std::vector<float>(64, 0),
                        .min_m = low,
                        .max_m = high,
                        .height_m = scene.rain.box_max_m.z()};
  scene.rain.density.share[1 * 8 + 5] = 1;  // from the north, and from the west
  sum_density(scene.rain.density);
  const Frame frame = draw(scene);
  expect_sound(frame);
  EXPECT_GT(frame.streaks_in_view, 100);
  // A level camera shows a column of rain as columns of pixels, and a streak is 7 mm wide.
  const Eigen::Vector2d side = (high - low) / 8;
  const double focal_px = camera_frame(scene.camera).focal_px;
  const auto column_px = [&](int x, int y) {
    const Eigen::Vector2d away =
        low + side.cwiseProduct(Eigen::Vector2d(x, y)) - scene.camera.position_m.head<2>();
    return 80 + focal_px * away.x() / away.y();
  };
  const double left_px = std::min(column_px(5, 6), column_px(5, 7)) - 1.5;
  const double right_px = std::max(column_px(6, 6), column_px(6, 7)) + 1.5;
  ASSERT_LT(right_px - left_px, 80);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const bool below = x + 1 > left_px && x < right_px;
      EXPECT_TRUE(below || frame.rain_tau.at(x, y) == 0) << x;
    }
  }
}

// Fog that glows, shadows, splashes, and all kinds of light.
Scene scene_of_all_effects() {
  Scene scene = rainy_scene(2000);
  Light spot{"spot", {1, 6, 4}, {500, 500, 500}, LightKind::spot};
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(0.3, -0.9, -0.4).normalized();
  sun.illuminance_lux = {50, 40, 30};
  scene.lights.push_back(spot);
  scene.lights.push_back(sun);
  for (Light& light : scene.lights) light.shadow = true;
  add_rectangle(scene.mesh, {-1, 4, 2}, {2, 0, 0}, {0, 2, 0}, {});
  scene.fog = Fog{.extinction_per_m = 0.02};
  scene.glow.emplace();
  scene.splashes.emplace();
  return scene;
}

TEST(HardScene, AllEffectsAtOnceLoseNoNumber) {
  PLUVIA_NEEDS_OPENGL();
  struct Oddity {
    const char* name;
    void (*change)(Scene&);
  };
  const Oddity oddities[] = {
      {"none", [](Scene&) {}},
      {"one second", [](Scene& s) { s.camera.exposure_s = 1; }},
      {"no light", [](Scene& s) { s.lights.clear(), s.environment = {}; }},
      {"no surface", [](Scene& s) { s.mesh = {}; }},
      {"along the fall",
       [](Scene& s) { s.camera.target_m = s.camera.position_m - Eigen::Vector3d(0, 0, 1); }},
      {"a lamp in the lens", [](Scene& s) { s.lights[0].position_m = s.camera.position_m; }},
      {"a lamp a centimetre ahead",
       [](Scene& s) {
         s.lights[0].position_m = s.camera.position_m + Eigen::Vector3d(0, 0.01, 0);
         s.camera.target_m = s.lights[0].position_m;
       }},
      {"lamps on the ground",
       [](Scene& s) {
         for (Light& l : s.lights) l.position_m.z() = 0;
       }},
      {"a lens on the ground",
       [](Scene& s) { s.camera.position_m.z() = s.camera.target_m.z() = 0; }},
      {"fog that scatters straight on", [](Scene& s) { s.fog->asymmetry = 0.99; }},
      {"fog that scatters straight back, and hides all",
       [](Scene& s) { s.fog = {.extinction_per_m = 100, .asymmetry = -0.99}; }},
      {"a sun from below",
       [](Scene& s) {
         s.lights[3].direction = {0, 0, 1};
       }},
      {"one pixel", [](Scene& s) { s.camera.width_px = s.camera.height_px = 1; }},
      {"150 degrees", [](Scene& s) { s.camera.vertical_fov_deg = 150; }}};
  for (const Oddity& oddity : oddities) {
    SCOPED_TRACE(oddity.name);
    Scene scene = scene_of_all_effects();
    oddity.change(scene);
    const Frame frame = draw(scene);
    expect_sound(frame);
    EXPECT_TRUE(all_finite(frame.background));
    for (const float depth_m : frame.depth_m.values) ASSERT_GT(depth_m, 0);  // sky: infinity
  }
}

TEST(HardScene, NoExposureIsNoStreak) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(100);
  scene.camera.exposure_s = 0;
  EXPECT_EQ(message_of([&] { draw(scene); }),
            "scene: camera.exposure_s = 0 s; expected 0.00038 s or more, in which a drop of 3.2 mm "
            "falls its own diameter: less shows drops, not streaks");
}

TEST(HardScene, AHurricaneOfTinyDropsIsDrawn) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.rain.sizes = {{.r0_m = 5e-5, .drops_per_m3 = 50, .velocity_m_s = {60, 0, -0.2}},
                      {.r0_m = 4e-3, .drops_per_m3 = 1, .velocity_m_s = {60, -30, -9}}};
  const Frame frame = draw(scene);
  expect_sound(frame);
  EXPECT_GT(frame.streaks_in_view, 100);
}

TEST(HardScene, RainSoDenseThatNothingPassesStillHidesWhatIsBehind) {
  PLUVIA_NEEDS_OPENGL();
  // exp(-sigma d) is less than any float, and the pixel must not count as dry.
  Scene scene = rainy_scene(0);
  scene.mesh = {};
  scene.rain.sizes = {{.r0_m = 5e-3, .drops_per_m3 = 1e5}};
  scene.rain.box_min_m = {-0.5, 13.3, 1};
  scene.rain.box_max_m = {0.5, 13.4, 2.5};
  scene.camera.target_m = {0.3, 9, 1.7};
  const Frame frame = draw(scene);
  expect_sound(frame);
  EXPECT_GT(frame.streaks_in_view, 1000);
  for (std::size_t i = 0; i < frame.rain_tau.values.size(); ++i) {
    const float tau = frame.rain_tau.values[i];
    if (tau < 1e-3f) continue;
    EXPECT_GT(frame.rain.values[3 * i], 0) << tau;
    EXPECT_NE(frame.color.values[3 * i], frame.background.values[3 * i]);
  }
}

TEST(HardScene, AMissingShaderFileIsNamed) {
  const std::string message = message_of([] {
    flatten_shader("rain.frag", {}, {{"rain.frag", "#version 450 core\n#include \"none.glsl\"\n"}});
  });
  EXPECT_NE(message.find("realtime/shaders/rain.frag:2"), std::string::npos) << message;
  EXPECT_NE(message.find("none.glsl"), std::string::npos) << message;
}

}  // namespace
}  // namespace pluvia
