// Fog and glow as the renderer draws them, and what a frame plan says of effects.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "raytrace/light.h"
#include "raytrace/rain_fog.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

Eigen::Vector3d direction_of(const Camera& camera, int x, int y) {
  const CameraFrame frame = camera_frame(camera);
  return (frame.focal_px * frame.forward + (x + 0.5 - camera.width_px / 2.0) * frame.right -
          (y + 0.5 - camera.height_px / 2.0) * frame.up)
      .normalized();
}

const PlannedPass* pass_of(const FramePlan& plan, const std::string& name) {
  for (const PlannedPass& pass : plan.passes) {
    if (pass.name == name) return &pass;
  }
  return nullptr;
}

TEST(Fog, VeilsSurfacesAndSkyAsItsFormulaSays) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(3000);
  scene.rain.culling_radius_m = 5;
  scene.rain.local_height_m = 4;
  scene.rain.undrawn_per_m = 5e-3;
  scene.camera.target_m = {1, 5, 1.2};
  const Frame clear = RainRenderer(scene, quarter_atlas()).render(0);
  scene.fog = Fog{.extinction_per_m = 0.02};
  RainRenderer renderer(scene, quarter_atlas());
  const Frame frame = renderer.render(0);
  const RainFog fog = rain_fog(scene, make_rain_space(scene));
  int surfaces = 0, sky = 0;
  for (int y = 2; y < 118; ++y) {
    for (int x = 2; x < 158; ++x) {
      const float depth = frame.depth_m.at(x, y);
      // Pixels whose neighbours are of one kind and nearly as far: four samples share a pixel.
      if (!(std::abs(frame.depth_m.at(x, y + 1) - frame.depth_m.at(x, y - 1)) < 0.2f * depth) &&
          !(std::isinf(depth) && std::isinf(frame.depth_m.at(x, y + 1))))
        continue;
      const Eigen::Vector3d d = direction_of(scene.camera, x, y);
      const double distance_m = std::isinf(depth) ? 1e6
                                                  : static_cast<double>(depth) /
                                                        d.dot(camera_frame(scene.camera).forward);
      const double left = std::exp(-fog_depth(fog, d, distance_m));
      for (int c = 0; c < 3; ++c) {
        const double expected = left * static_cast<double>(clear.background.at(x, y, c)) +
                                (1 - left) * scene.environment.uniform_cd_m2[c];
        // The mean of four samples of exp over a pixel's depths: half a pixel's change squared.
        EXPECT_NEAR(static_cast<double>(frame.background.at(x, y, c)), expected, 4e-3 * expected)
            << x << ", " << y;
      }
      (std::isinf(depth) ? sky : surfaces) += 1;
    }
    if (testing::Test::HasFailure()) FAIL();
  }
  EXPECT_GT(surfaces, 1000);
  EXPECT_GT(sky, 1000);
}

TEST(Fog, DimsAStreakByWhatLiesBeforeIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.drops = {{.centre_m = {0.8, 9, 2}}};
  const Frame clear = RainRenderer(scene, quarter_atlas()).render(0);
  scene.fog = Fog{.extinction_per_m = 0.1};
  const Frame frame = RainRenderer(scene, quarter_atlas()).render(0);
  const Eigen::Vector3d middle(0.8, 9, 2 - 8.49 / 120);
  const double left = std::exp(-0.1 * (middle - scene.camera.position_m).norm());
  for (int c = 0; c < 3; ++c) {
    double before = 0, after = 0;
    for (std::size_t i = 0; i < frame.rain.values.size(); i += 3) {
      before += static_cast<double>(clear.rain.values[i + static_cast<std::size_t>(c)]);
      after += static_cast<double>(frame.rain.values[i + static_cast<std::size_t>(c)]);
    }
    EXPECT_GT(before, 0);
    EXPECT_NEAR(after / before, left, 1e-4);
  }
  EXPECT_EQ(frame.rain_tau.values, clear.rain_tau.values) << "it hides as much as before";
}

// int sigma E p exp(-tau) ds over an even mist, by 20,000 steps of equal length.
Eigen::Vector3d glow_along(const Scene& scene, const Eigen::Vector3d& d, double far_m) {
  const double sigma = scene.fog->extinction_per_m, g = scene.fog->asymmetry;
  Eigen::Vector3d sum(0, 0, 0);
  for (const Light& light : scene.lights) {
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
      const double s = (i + 0.5) / steps * far_m;
      const Illumination lit = illumination(light, scene.camera.position_m + s * d);
      const double cosine = lit.toward.dot(d);
      const double phase =
          (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
      const double beyond = std::isinf(lit.distance_m) ? 0 : lit.distance_m;
      sum += sigma * phase * std::exp(-sigma * (s + beyond)) * far_m / steps * lit.lux;
    }
  }
  return sum;
}

TEST(Fog, GlowIsTheIntegralOfTheLightThatIsScatteredOnce) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene;
  scene.camera.width_px = 64;
  scene.camera.height_px = 48;
  scene.camera.position_m = {0, 0, 1.6};
  scene.camera.target_m = {0, 5, 2.5};
  Light spot{"spot", {3, 9, 5}, {0, 300, 0}, LightKind::spot};
  spot.direction = Eigen::Vector3d(-0.4, -0.2, -1).normalized();
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(0.3, -0.9, -0.4).normalized();
  sun.illuminance_lux = {0, 0, 20};
  scene.lights = {{"lamp", {-1, 8, 4}, {500, 0, 0}}, spot, sun};
  for (const double asymmetry : {0.0, 0.7, 0.884}) {
    scene.fog = Fog{.extinction_per_m = 0.03, .asymmetry = asymmetry};
    scene.glow = Glow{};
    const Frame frame = RainRenderer(scene, StreakAtlas{}).render(0);
    double squared = 0, all[3] = {}, expected_all[3] = {};
    for (int y = 0; y < 48; y += 3) {
      for (int x = 0; x < 64; x += 3) {
        const Eigen::Vector3d expected = glow_along(scene, direction_of(scene.camera, x, y), 500);
        for (int c = 0; c < 3; ++c) {
          const double found = static_cast<double>(frame.background.at(x, y, c));
          all[c] += found;
          expected_all[c] += expected[c];
          squared += std::pow((found - expected[c]) / std::max(expected[c], 1e-3), 2);
        }
      }
    }
    // 16 samples of a ray: a spot's rim changes within one; and 2.5 cm of the sum beside a lamp.
    const double bounds[3] = {0.01, 0.03, 0.003};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(all[c] / expected_all[c], 1, bounds[c]) << c << ", " << asymmetry;
    EXPECT_LT(std::sqrt(squared / (16 * 22 * 3)), 0.1) << asymmetry;
  }
}

TEST(FramePlan, AnEffectThatIsNotCalledForContributesNothing) {
  PLUVIA_NEEDS_OPENGL();
  const auto plan_of = [](const Scene& scene) {
    return RainRenderer(scene, quarter_atlas()).plan();
  };
  Scene dry = rainy_scene(0);
  const FramePlan bare = plan_of(dry);
  EXPECT_EQ(bare.passes.size(), 2u);
  EXPECT_TRUE(pass_of(bare, "surfaces") && pass_of(bare, "composite"));
  // Each effect adds its own pass, and changes bytes and shaders of no other.
  struct Effect {
    const char* pass;
    Scene scene;
  };
  Scene fog = dry, shadows = dry, rain = dry;
  fog.fog = Fog{.extinction_per_m = 0.01};
  shadows.lights[0].shadow = true;
  rain.drops = {{.centre_m = {0.8, 3, 2.5}}};
  for (const Effect& effect : {Effect{"fog", fog}, {"shadows", shadows}, {"rain", rain}}) {
    const FramePlan plan = plan_of(effect.scene);
    EXPECT_EQ(plan.passes.size(), 3u) << effect.pass;
    const PlannedPass* own = pass_of(plan, effect.pass);
    ASSERT_TRUE(own) << effect.pass;
    EXPECT_GT(bytes_of(*own), 0u);
    EXPECT_FALSE(own->shaders.empty());
    for (const PlannedPass& pass : bare.passes) {
      const PlannedPass* same = pass_of(plan, pass.name);
      ASSERT_TRUE(same);
      EXPECT_EQ(bytes_of(*same), bytes_of(pass)) << effect.pass << " changes " << pass.name;
      EXPECT_EQ(same->shaders, pass.shaders);
    }
  }
  EXPECT_NE(plan_text(bare).find("surfaces"), std::string::npos);
}

TEST(FramePlan, WhatCannotBeSeenIsSkippedAndSaidSo) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(2000);
  scene.fog = Fog{};
  scene.rain.culling_radius_m = 60;
  scene.rain.box_max_m.z() = 1;  // below the camera
  scene.camera.target_m = {1, 5, 9};
  RainRenderer renderer(scene, quarter_atlas());
  const Frame frame = renderer.render(0);
  ASSERT_EQ(frame.costs.size(), 4u);
  EXPECT_EQ(frame.costs[1].pass, "fog");
  EXPECT_EQ(frame.costs[2].pass, "rain");
  EXPECT_EQ(frame.costs[2].skipped, "no streak in view");
  EXPECT_EQ(frame.costs[3].skipped, "");
  scene.rain.sizes.clear();
  const Frame dry = RainRenderer(scene, StreakAtlas{}).render(0);
  EXPECT_EQ(dry.costs[1].skipped, "the air is clear");
  EXPECT_NE(costs_json(renderer.plan(), {frame.costs}).find("\"skipped\": \"no streak in view\""),
            std::string::npos);
}

}  // namespace
}  // namespace pluvia
