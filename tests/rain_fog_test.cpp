#include "raytrace/rain_fog.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

Scene foggy_scene() {
  Scene scene;
  scene.camera.position_m = {1, 2, 3};
  scene.camera.target_m = {1, 9, 3};
  scene.rain.sizes = {{.drops_per_m3 = 20},
                      {.r0_m = 1e-3, .drops_per_m3 = 90},
                      {.r0_m = 0.6e-3, .drops_per_m3 = 300, .velocity_m_s = {6, -1, -4}}};
  scene.rain.box_min_m = {-30, -20, 0};
  scene.rain.box_max_m = {25, 40, 14};
  scene.rain.culling_radius_m = 6;
  scene.rain.local_height_m = 5;
  scene.rain.undrawn_per_m = 3e-4;
  scene.fog = Fog{.extinction_per_m = 2e-3};
  return scene;
}

// sigma at a point, by what the words say.
double sigma_at(const Scene& scene, const RainSpace& space, const Eigen::Vector3d& at_m) {
  double sigma = scene.fog->extinction_per_m + scene.rain.undrawn_per_m;
  const bool in_box = (at_m.array() >= scene.rain.box_min_m.array()).all() &&
                      (at_m.array() <= scene.rain.box_max_m.array()).all();
  if (!in_box) return sigma;
  for (std::size_t i = 0; i < scene.rain.sizes.size(); ++i) {
    const RainSizeSpace& size = space.sizes[i];
    const LocalSpace local = local_space(space, static_cast<int>(i), scene.camera.position_m, 0);
    const Eigen::Vector3d from = at_m - scene.camera.position_m;
    const double along = from.dot(size.frame.z);
    const double up = at_m.dot(size.frame.z) - local.floor_m;
    const bool drawn = (from - along * size.frame.z).norm() <= space.culling_radius_m && up >= 0 &&
                       up <= space.local_height_m;
    if (!drawn) sigma += size.drops.drops_per_m3 * std::numbers::pi * std::pow(size.drops.r0_m, 2);
  }
  return sigma;
}

TEST(RainFog, DepthIsTheIntegralOfWhatIsNotDrawn) {
  const Scene scene = foggy_scene();
  const RainSpace space = make_rain_space(scene);
  const RainFog fog = rain_fog(scene, space);
  EXPECT_EQ(fog.slabs.size(), 2u) << "two sizes fall alike";
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 60; ++trial) {
    const Eigen::Vector3d d =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    for (const double distance_m : {0.5, 7.0, 60.0}) {
      constexpr int steps = 20000;
      double sum = 0;
      for (int i = 0; i < steps; ++i) {
        const double s = (i + 0.5) / steps * distance_m;
        sum += sigma_at(scene, space, scene.camera.position_m + s * d) * distance_m / steps;
      }
      // Each of at most 8 borders is off by half a step.
      const double step = distance_m / steps * 2e-3;
      EXPECT_NEAR(fog_depth(fog, d, distance_m), sum, 4 * step + 1e-12) << d.transpose();
    }
  }
}

TEST(RainFog, LookingAlongAnAxisOrForEverIsFine) {
  Scene scene = foggy_scene();
  const RainSpace space = make_rain_space(scene);
  RainFog fog = rain_fog(scene, space);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& d :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 0, 0)}) {
    EXPECT_EQ(fog_depth(fog, d, infinity), infinity);
    EXPECT_TRUE(std::isfinite(fog_depth(fog, d, 1e6)));
    EXPECT_EQ(fog_depth(fog, d, 0), 0);
  }
  scene.fog->extinction_per_m = scene.rain.undrawn_per_m = 0;
  fog = rain_fog(scene, space);
  EXPECT_TRUE(std::isfinite(fog_depth(fog, {0, 0, 1}, infinity)));
  scene.camera.position_m = {1e3, 0, 3};  // outside the box, looking away
  EXPECT_EQ(fog_depth(rain_fog(scene, space), {1, 0, 0}, infinity), 0);
}

TEST(RainFog, WithoutItNothingIsVeiled) {
  Scene scene = foggy_scene();
  scene.fog.reset();
  const RainFog fog = rain_fog(scene, make_rain_space(scene));
  EXPECT_EQ(fog_depth(fog, {0, 1, 0}, 1e6), 0);
}

}  // namespace
}  // namespace pluvia
