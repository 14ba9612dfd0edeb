// Streaks that are not traced: as spheres, as published in 2006, white.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "atlas/image_io.h"
#include "raytrace/light.h"
#include "raytrace/sky_light.h"
#include "raytrace/sphere_closed_form.h"
#include "raytrace/sphere_transfer.h"
#include "realtime/rain_look.h"
#include "realtime/rain_renderer.h"
#include "tests/evening_sky.h"
#include "tests/frame_light.h"
#include "tests/frame_threads.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::Contains;
using testing::Not;

constexpr double pi = std::numbers::pi;
constexpr std::array looks = {StreakLook::traced, StreakLook::sphere, StreakLook::sphere_published,
                              StreakLook::white};

// One drop before the black, at the middle of the exposure 3 m away; the picture is as small as its
// streak, whose sums the walk rounds by 2^-16 of white a pixel.
Scene one_drop() {
  Scene scene;
  scene.camera = {.position_m = {0, 0, 0},
                  .target_m = {0, 3, 0.3},
                  .vertical_fov_deg = 6,
                  .width_px = 48,
                  .height_px = 96,
                  .exposure_s = 1.0 / 60,
                  .white_cd_m2 = 1};
  scene.drops = {{.centre_m = Eigen::Vector3d(0.03, 3, 0.3) - Eigen::Vector3d(0, 0, -8.49 / 120)}};
  return scene;
}
const Eigen::Vector3d onward = Eigen::Vector3d(0.03, 3, 0.3).normalized();  // from the eye to it

// A sun whose light is turned by an angle on its way through the drop.
Light sun_at(double angle_rad) {
  const Eigen::Vector3d axis = onward.cross(Eigen::Vector3d(0.3, 0.1, 1)).normalized();
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = -(Eigen::AngleAxisd(angle_rad, axis) * onward);
  sun.illuminance_lux = {500, 400, 300};  // a brighter one would light quads
  return sun;
}

// Mean radiance of what is covered. walked: by rain_splat.comp; else as quads.
Eigen::Vector3d brightness(const Scene& scene, RenderOptions options, bool walked) {
  options.widest_splat_px = walked ? 16 : 0;
  RainRenderer renderer(scene, sky_atlas(), options);
  EXPECT_EQ(renderer.streak_records(0).streaks.empty(), walked);
  const Frame frame = renderer.render(0);
  EXPECT_EQ(frame.streaks_in_view, 1);
  return brightness(frame);
}

// Quads: floats, whose sums go down a table of coverage: 1e-5. Walked: 100 pixels are rounded to
// 2^-16 of white, of a sum of at least 1, each by 0.3 of it (one sigma) without a bias: 5e-5; and
// 0.1 % of two steps in one pixel (docs/rendering.md), of light and coverage alike but for the
// order in which they are hidden.
constexpr double tolerance[] = {1e-5, 1e-3};

TEST(Look, AStreakUnderALampIsEDAsBrightAtEveryAngle) {
  PLUVIA_NEEDS_OPENGL();
  const double bow = sphere_rainbow_rad(1.333, 2);
  for (const double angle : {0.0, 1e-3, 0.5, pi / 2, 2.0, bow, pi - 1e-3, pi}) {
    Scene scene = one_drop();
    scene.lights = {sun_at(angle)};
    for (const auto look : {StreakLook::sphere, StreakLook::sphere_published}) {
      const bool published = look == StreakLook::sphere_published;
      const auto rings =
          sphere_transfer({.averaged_reflectance = published, .single_root = published}, 360);
      const double d = transfer_at(rings, angle);
      for (const bool walked : {false, true}) {
        // c = 0: the coverage in the picture is the streak's.
        const auto found = brightness(scene, {.look = look, .background_share = 0}, walked);
        for (int c = 0; c < 3; ++c) {
          const double expected = d * scene.lights[0].illuminance_lux[c];
          // Directions in float err by 1e-7 and turns by 2e-7 in each step: 9e-7 of a turn, of a
          // ring of 0.0087 in which D may double: 1e-4.
          EXPECT_NEAR(found[c] / expected, 1, tolerance[walked] + 1e-4)
              << angle << ", published " << published << ", walked " << walked;
        }
      }
    }
  }
}

TEST(Look, AwayFromBowsItIsTheClosedForm) {
  PLUVIA_NEEDS_OPENGL();
  for (const double angle : {0.4, 0.9, pi / 2}) {
    Scene scene = one_drop();
    scene.lights = {{.name = "lamp", .position_m = {}, .intensity_cd = {8000, 4000, 2000}}};
    const Eigen::Vector3d middle(0.03, 3, 0.3);
    scene.lights[0].position_m = middle - 2.5 * sun_at(angle).direction;
    double d = 0;
    for (int p = 0; p < 9; ++p) d += sphere_order_intensity(1.333, p, angle);
    const auto found = brightness(scene, {.look = StreakLook::sphere}, false);
    const Eigen::Vector3d lux = illumination(scene.lights[0], middle).lux;
    // Half-degree rings, h = 0.0087: ring means and chords are off by h^2 (1/24 + 1/8) D'' / D,
    // 1.3e-5 D'' / D, and D'' / D is below 30 there but for the bows of high orders, that together
    // hold 2e-3 of the light.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / (lux[c] * d), 1, 3e-3) << angle;
  }
}

TEST(Look, UnderAUniformSkyADropIsAsBrightAsTheSky) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_drop();
  scene.environment.uniform_cd_m2 = {30, 20, 10};
  for (const bool walked : {false, true}) {
    const auto found = brightness(scene, {.look = StreakLook::sphere}, walked);
    // Nine terms leave 2.1e-4 out.
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found[c] / scene.environment.uniform_cd_m2[c], transfer_harmonics({}, 0)[0],
                  tolerance[walked])
          << walked;
  }
}

TEST(Look, ASkyIsSeenByItsZonalHarmonics) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = one_drop();
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 100};
  write_exr(scene.environment.map_file, evening_map());
  const Image map = read_environment_map(scene.environment.map_file);
  std::array<double, 4> greens = {};
  for (const int degree : {0, 1, 2, 3}) {
    const SkyLight sky = sky_light(scene.environment, &map, degree);
    ASSERT_EQ(degree_of(sky), degree);
    const Eigen::VectorXd seen = transfer_seen_from(transfer_harmonics({}, degree), -onward);
    const Eigen::Vector3d expected = sky.coefficients.transpose() * seen;
    const auto found = brightness(scene, {.look = StreakLook::sphere, .sky_degree = degree}, false);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1, 2e-5) << degree;
    greens[static_cast<std::size_t>(degree)] = found.y();
  }
  for (const int degree : {1, 2, 3})
    EXPECT_GT(std::abs(greens[static_cast<std::size_t>(degree)] -
                       greens[static_cast<std::size_t>(degree) - 1]),
              1e-3 * greens[0])
        << degree;
  // More than it was published with is not seen.
  EXPECT_EQ(brightness(scene, {.look = StreakLook::sphere, .sky_degree = 8}, false).y(), greens[3]);
}

TEST(Look, AShareOfTheBackgroundIsAddedToAStreak) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_drop();
  scene.environment.uniform_cd_m2 = {30, 20, 10};  // behind the streak, too
  scene.lights = {sun_at(1.2)};
  for (const bool walked : {false, true}) {
    const double splat_px = walked ? 16 : 0;
    const auto frame_of = [&](double share) {
      return RainRenderer(scene, quarter_atlas(),
                          {.widest_splat_px = splat_px,
                           .look = StreakLook::sphere,
                           .background_share = share})
          .render(0);
    };
    const Frame none = frame_of(0), some = frame_of(0.7);
    int wet = 0;
    for (std::size_t i = 0; i < none.rain_tau.values.size(); ++i) {
      const double a = -std::expm1(-static_cast<double>(none.rain_tau.values[i]));
      wet += a > 1e-3 ? 1 : 0;
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
        const double b = static_cast<double>(none.background.values[k]);
        const double before = static_cast<double>(none.color.values[k]);
        // C' = C + 0.7 B: a C' + (1 - a) B is 0.7 a B more than a C + (1 - a) B. Walked: two steps
        // in a pixel hide (a / 2)^2 of each other's; shares are rounded to 2^-22.
        const double rounding = 1e-5 + (walked ? a * a + 1e-4 : 0);
        EXPECT_NEAR(static_cast<double>(some.color.values[k]), before + 0.7 * a * b,
                    rounding * (b + before));
      }
    }
    EXPECT_GT(wet, 20);
  }
}

TEST(Look, ManyStreaksHideABackgroundByTheRestOfTheShare) {
  PLUVIA_NEEDS_OPENGL();
  // Where streaks are black, only what they hide is seen: exp(-sum tau((1 - c) a)).
  Scene scene = rainy_scene(20000);
  scene.lights.clear();
  for (const double splat_px : {0.0, 1.0}) {
    const auto tau_of = [&](double share) {
      return RainRenderer(scene, quarter_atlas(),
                          {.widest_splat_px = splat_px,
                           .look = StreakLook::sphere,
                           .background_share = share})
          .render(0.5)
          .rain_tau;
    };
    const Image all = tau_of(0), rest = tau_of(0.75);
    double sums[2] = {};
    for (std::size_t i = 0; i < all.values.size(); ++i) {
      sums[0] += static_cast<double>(all.values[i]);
      sums[1] += static_cast<double>(rest.values[i]);
      // -log(1 - a / 4) <= -log(1 - a) / 4.
      EXPECT_LE(rest.values[i], 0.25f * all.values[i] + 1e-5f);
    }
    EXPECT_GT(sums[0], 1);
    EXPECT_NEAR(sums[1] / sums[0], 0.25, 0.25 * 0.02);  // a is a few hundredths
  }
}

TEST(Look, WhiteIsOneRadianceWhateverTheLight) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_drop();
  for (const bool walked : {false, true}) {
    const auto found = brightness(scene, {.look = StreakLook::white, .streak_cd_m2 = 7.5}, walked);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / 7.5, 1, tolerance[walked]);
    Scene lit = scene;
    lit.lights = {sun_at(1)};
    lit.environment.uniform_cd_m2 = {30, 20, 10};
    EXPECT_EQ(brightness(lit, {.look = StreakLook::white, .streak_cd_m2 = 7.5}, walked), found);
  }
  scene.camera.white_cd_m2 = 3;
  EXPECT_NEAR(brightness(scene, {.look = StreakLook::white}, false).x(), 3, 3e-5);
}

TEST(Look, FogDimsAStreakAsItDimsATracedOne) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = one_drop();
  scene.lights = {sun_at(0.7)};
  for (const auto look : looks) {
    scene.fog.reset();
    const double clear = brightness(scene, {.look = look}, false).x();
    scene.fog = Fog{.extinction_per_m = 0.1};
    const double left = std::exp(-0.1 * Eigen::Vector3d(0.03, 3, 0.3).norm());
    EXPECT_NEAR(brightness(scene, {.look = look}, false).x() / clear, left, 1e-5)
        << static_cast<int>(look);
  }
}

TEST(Look, CoversWhatATracedStreakCovers) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(20000);
  for (const double splat_px : {0.0, 1.0}) {
    const auto tau_of = [&](StreakLook look) {
      RenderOptions options = {.widest_splat_px = splat_px, .look = look};
      if (look == StreakLook::sphere_published) options.background_share = 0;
      return RainRenderer(scene, quarter_atlas(), options).render(0.5).rain_tau.values;
    };
    const std::vector<float> traced = tau_of(StreakLook::traced);
    // A streak may be bright enough to be a quad in one look and not in another: 0.2 % of tau.
    for (const auto look : looks) {
      const std::vector<float> found = tau_of(look);
      double off = 0, all = 0;
      for (std::size_t i = 0; i < found.size(); ++i) {
        off += static_cast<double>(std::abs(found[i] - traced[i]));
        all += static_cast<double>(traced[i]);
      }
      EXPECT_LE(off, (splat_px > 0 ? 2e-3 : 1e-6) * all) << static_cast<int>(look);
    }
  }
}

TEST(Look, EveryPictureIsOfNumbers) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene rain = rainy_scene(3000);
  rain.drops = {{.centre_m = {0.3, -0.2, 1.7}}, {.centre_m = {0.3, 5, 4}}};
  rain.drops[1].velocity_m_s = {0, 8, 0};  // away from the eye: an axis of no width
  Scene fog = rain, lens = rain, shadows = rain, sky = rain;
  fog.fog = Fog{.extinction_per_m = 0.15};
  fog.glow = Glow{};
  fog.splashes.emplace();
  lens.camera.depth_of_field = DepthOfField{.aperture_m = 0.1, .focus_m = 4};
  shadows.lights[0].shadow = true;
  sky.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(sky.environment.map_file, evening_map());
  for (const Scene* scene : {&rain, &fog, &lens, &shadows, &sky}) {
    for (const auto look : looks) {
      const Frame frame = RainRenderer(*scene, sky_atlas(), {.look = look}).render(0.5);
      for (const Image* image : {&frame.color, &frame.rain, &frame.rain_tau})
        EXPECT_TRUE(all_finite(*image)) << static_cast<int>(look);
      EXPECT_GT(frame.streaks_in_view, 100);
      EXPECT_GT(light(frame, 0), 0) << static_cast<int>(look);
    }
  }
}

std::map<std::string, std::size_t> resources_of(const PlannedPass& pass) {
  std::map<std::string, std::size_t> found;
  for (const PlannedResource& resource : pass.resources) found[resource.name] = resource.bytes;
  return found;
}

PlannedPass rain_of(const Scene& scene, const RenderOptions& options) {
  for (const PlannedPass& pass : RainRenderer(scene, sky_atlas(), options).plan().passes) {
    if (pass.name == "rain") return pass;
  }
  return {};
}

TEST(Look, WhatItDoesNotNeedIsNeitherUploadedNorCompiled) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = rainy_scene(1000);
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(scene.environment.map_file, evening_map());
  const PlannedPass traced = rain_of(scene, {});
  const auto with = resources_of(traced);
  EXPECT_THAT(traced.shaders, Contains("rain_light.glsl"));
  EXPECT_THAT(traced.shaders, Not(Contains("rain_look.glsl")));
  EXPECT_FALSE(with.contains("transfer function") || with.contains("sky as spheres see it"));
  const char* light_of_traced[] = {"atlas: lights",
                                   "atlas: lights by direction",
                                   "atlas: layers",
                                   "atlas: sums of the sky",
                                   "sky",
                                   "atlas: rows of lights",
                                   "atlas: spans of the sky"};
  for (const auto look : {StreakLook::sphere, StreakLook::sphere_published, StreakLook::white}) {
    for (const auto lookup : {LookupMode::view_linear, LookupMode::trilinear}) {
      const PlannedPass plan = rain_of(scene, {.lookup = lookup, .look = look});
      const auto without = resources_of(plan);
      EXPECT_THAT(plan.shaders, Not(Contains("rain_light.glsl")));
      EXPECT_THAT(plan.shaders, Contains("rain_look.glsl"));
      for (const char* name : light_of_traced) EXPECT_FALSE(without.contains(name)) << name;
      // One cell, coverage, for 74 lights and coverage. Textures are whole layers of 4 M texels.
      EXPECT_LE(without.at("atlas: sums"), with.at("atlas: sums"));
      EXPECT_LT(without.at("thin streaks: profiles"), with.at("thin streaks: profiles"));
      const bool sphere = look != StreakLook::white;
      EXPECT_EQ(without.contains("transfer function"), sphere);
      EXPECT_EQ(without.contains("sky as spheres see it"), sphere);
      EXPECT_FALSE(plan.notes.empty());
    }
  }
  scene.lights.clear();
  const auto dark = resources_of(rain_of(scene, {.look = StreakLook::sphere}));
  EXPECT_FALSE(dark.contains("transfer function"));
  EXPECT_TRUE(dark.contains("sky as spheres see it"));
  scene.environment = {};
  const auto black = resources_of(rain_of(scene, {.look = StreakLook::sphere}));
  EXPECT_FALSE(black.contains("sky as spheres see it"));
}

TEST(Look, OfTheAtlasCoverageAloneIsSummed) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(1000);
  const auto bytes = [&](StreakLook look) {
    return RainRenderer(scene, quarter_atlas(), {.look = look}).atlas_bytes();
  };
  // 74 lights, the uniform sky, coverage; each rounded up to rows of the texture.
  const std::size_t cells = quarter_atlas().lights.size() + 2, row = 4096 * sizeof(float);
  EXPECT_GE(cells * bytes(StreakLook::sphere), bytes(StreakLook::traced));
  EXPECT_LE(cells * (bytes(StreakLook::sphere) - row), bytes(StreakLook::traced));
  EXPECT_EQ(bytes(StreakLook::white), bytes(StreakLook::sphere));
}

TEST(Look, ARendererThatTakesAnotherIsAsOneMadeForIt) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(2000);
  RainRenderer renderer(scene, quarter_atlas());
  for (const auto look : {StreakLook::sphere, StreakLook::white, StreakLook::traced}) {
    renderer.remake(scene, quarter_atlas(), {.look = look});
    EXPECT_EQ(renderer.render(0.5).color.values,
              RainRenderer(scene, quarter_atlas(), {.look = look}).render(0.5).color.values)
        << static_cast<int>(look);
  }
}

// The number of threads is read once in a process, so each runs this very test with a file to
// write.
TEST(Look, AFrameHasTheSameBytesForEveryNumberOfThreads) {
  PLUVIA_NEEDS_OPENGL();
  if (const char* file = file_of_rerun()) {
    std::ofstream out(file, std::ios::binary);
    for (const auto look : looks) {
      const Frame frame =
          RainRenderer(rainy_scene(20000), quarter_atlas(), {.look = look}).render(0.5);
      append_bytes(out, frame.color);
    }
    return;
  }
  const std::vector<std::string> frames = bytes_of_reruns({1, 2});
  EXPECT_EQ(frames[0].size(), looks.size() * 160 * 120 * 3 * sizeof(float));
  EXPECT_TRUE(frames[0] == frames[1]);
}

TEST(Look, NonsenseIsRefused) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = one_drop();
  const RenderOptions nonsense[] = {{.path = RainPath::billboards_2010, .look = StreakLook::sphere},
                                    {.background_share = 0.5},
                                    {.look = StreakLook::white, .background_share = 0.5},
                                    {.look = StreakLook::sphere, .background_share = 1},
                                    {.look = StreakLook::sphere, .background_share = -0.1},
                                    {.look = StreakLook::sphere, .background_share = std::nan("")},
                                    {.look = StreakLook::sphere, .streak_cd_m2 = 1},
                                    {.look = StreakLook::white, .streak_cd_m2 = -1},
                                    {.look = StreakLook::white, .streak_cd_m2 = std::nan("")}};
  for (const RenderOptions& options : nonsense)
    EXPECT_THROW(RainRenderer(scene, quarter_atlas(), options), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
