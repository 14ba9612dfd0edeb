#include "raytrace/rain_space.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

// A camera in a wide box of rain, looking level and a little up.
Scene wide_scene() {
  Scene scene;
  scene.camera.position_m = {0, 0, 1.6};
  scene.camera.target_m = {0, 5, 2.4};
  scene.rain.sizes = {{.drops_per_m3 = 3}};
  scene.rain.box_min_m = {-60, -60, 0};
  scene.rain.box_max_m = {60, 60, 30};
  return scene;
}

// How much of the rain in view is outside the local space, by counting: a drop adds its area over
// its squared distance, dimmed by the rain before it.
double counted_share(const Scene& scene, const RainSpace& space) {
  Scene whole = scene;
  whole.rain.culling_radius_m = 200;
  whole.rain.local_height_m = 30;
  const CameraFrame frame = camera_frame(scene.camera);
  const double slope_x = scene.camera.width_px / 2.0 / frame.focal_px;
  const double slope_y = scene.camera.height_px / 2.0 / frame.focal_px;
  double sigma = 0;
  for (const RainSize& size : scene.rain.sizes)
    sigma += size.drops_per_m3 * std::numbers::pi * size.r0_m * size.r0_m;
  double seen = 0, lost = 0;
  std::vector<LocalSpace> locals;
  for (std::size_t i = 0; i < space.sizes.size(); ++i)
    locals.push_back(local_space(space, static_cast<int>(i), scene.camera.position_m, 0));
  for (const Drop& drop : drop_field(whole, make_rain_space(whole), 1, 0)) {
    const Eigen::Vector3d c = drop.centre_m - scene.camera.position_m;
    const double depth = c.dot(frame.forward);
    if (!(depth > 0.1 && std::abs(c.dot(frame.right)) < slope_x * depth &&
          std::abs(c.dot(frame.up)) < slope_y * depth))
      continue;
    const auto index = static_cast<std::size_t>(drop.name.size);
    const FallFrame& fall = space.sizes[index].frame;
    const double cosine = depth / c.norm();
    // Per solid angle of the picture's pixels, which is cos^3 of a square one's in the middle.
    const double weight =
        drop.r0_m * drop.r0_m / c.squaredNorm() / std::pow(cosine, 3) * std::exp(-sigma * c.norm());
    const double z = drop.centre_m.dot(fall.z) - locals[index].floor_m;
    const bool in_local = std::hypot(c.dot(fall.x), c.dot(fall.y)) <= space.culling_radius_m &&
                          z >= 0 && z <= space.local_height_m;
    seen += weight;
    if (!in_local) lost += weight;
  }
  return lost / seen;
}

TEST(RainSpace, LosesNoMoreOfTheVisibleRainThanAsked) {
  // Counting has the noise of 10^4 drops, a hundredth of their sum, and the near ones count most:
  // three hundredths of the share, and 0.002. Where the worst of two directions decides, the other
  // loses less.
  for (const double bound : {0.02, 0.1, 0.4}) {
    for (const auto& sizes : {std::vector<RainSize>{{.drops_per_m3 = 3}},
                              std::vector<RainSize>{{.drops_per_m3 = 3, .velocity_m_s = {4, 2, -7}},
                                                    {.r0_m = 1e-3, .drops_per_m3 = 3}}}) {
      Scene scene = wide_scene();
      scene.rain.sizes = sizes;
      scene.rain.lost_share = bound;
      const RainSpace space = make_rain_space(scene);
      EXPECT_LE(space.lost_share, bound);
      EXPECT_GT(space.lost_share, 0.8 * bound) << "larger than needed";
      EXPECT_LE(counted_share(scene, space), bound * 1.03 + 0.002);
      EXPECT_GT(counted_share(scene, space), bound * (sizes.size() > 1 ? 0.3 : 0.7));
    }
  }
}

TEST(RainSpace, ASmallerBoundNeedsMoreDrops) {
  double before = 0;
  for (const double bound : {0.5, 0.2, 0.1, 0.05, 0.01}) {
    Scene scene = wide_scene();
    scene.rain.lost_share = bound;
    const double drops = make_rain_space(scene).expected_drops;
    EXPECT_GT(drops, before);
    before = drops;
  }
}

TEST(RainSpace, ABoxTooSmallForTheRaysIsStillReached) {
  // 30 cm, 10 m away, between the rays of the picture.
  Scene scene;
  scene.camera.position_m = {0, 0, 0};
  scene.camera.target_m = {0, 1, 0};
  scene.rain.sizes = {{.drops_per_m3 = 3000}};
  scene.rain.box_min_m = {-0.15, 9.8, -0.15};
  scene.rain.box_max_m = {0.15, 10.2, 0.15};
  const auto drops = drop_field(scene, make_rain_space(scene), 1, 0).size();
  EXPECT_NEAR(static_cast<double>(drops), 108, 5 * std::sqrt(108));
}

TEST(RainSpace, ManyDirectionsOfFallShareOneBudgetOfTexels) {
  Scene scene = wide_scene();
  for (int i = 0; i < 15; ++i)
    scene.rain.sizes.push_back({.drops_per_m3 = 1, .velocity_m_s = {0.3 * i + 0.3, 1, -6}});
  scene.mesh.positions_m = {{-200, -200, 0}, {200, -200, 0}, {0, 300, 0}};
  scene.mesh.indices = {0, 1, 2};
  const RainSpace space = make_rain_space(scene);
  std::size_t texels = 0;
  for (const TopHeight& top : space.tops) texels += top.texels.size();
  EXPECT_EQ(space.tops.size(), 16u);
  EXPECT_LT(texels, (1u << 22) + 200000);  // rows and columns at the rims
}

TEST(RainSpace, ACapOnDropsCountsThoseThatFallWhereTheCameraIs) {
  Scene scene = wide_scene();
  scene.rain.sizes[0].drops_per_m3 = 1e6;
  scene.rain.culling_radius_m = 4;
  scene.rain.local_height_m = 3;
  EXPECT_NE(message_of([&] { make_rain_space(scene); }).find("expected at most 20000000"),
            std::string::npos);
  // White around the camera alone: as many as before. White elsewhere: none.
  DensityMap& map = scene.rain.density;
  map = {.width = 12,
         .height = 12,
         .share = std::vector<float>(144, 0),
         .min_m = {-60, -60},
         .max_m = {60, 60},
         .height_m = 30};
  for (const std::size_t i : {65u, 66u, 77u, 78u}) map.share[i] = 1;
  sum_density(map);
  EXPECT_NE(message_of([&] { make_rain_space(scene); }).find("expected at most 20000000"),
            std::string::npos);
  map.share.assign(144, 0);
  map.share[0] = 1;
  sum_density(map);
  EXPECT_EQ(make_rain_space(scene).expected_drops, 0);
}

TEST(RainSpace, WhatTheSceneNamesIsTaken) {
  Scene scene = wide_scene();
  scene.rain.culling_radius_m = 11;
  RainSpace space = make_rain_space(scene);
  EXPECT_EQ(space.culling_radius_m, 11);
  scene.rain.local_height_m = 6;
  space = make_rain_space(scene);
  EXPECT_EQ(space.culling_radius_m, 11);
  EXPECT_EQ(space.local_height_m, 6);
  EXPECT_EQ(space.lost_share, lost_share(scene, 11, 6));
  EXPECT_GT(space.lost_share, lost_share(scene, 22, 6));
  EXPECT_EQ(lost_share(scene, 200, 40), 0);
}

TEST(RainSpace, RainWithoutBoundsIsRefusedUnlessTheSceneSaysHowFar) {
  Scene scene = wide_scene();
  scene.rain.box_min_m = Rain().box_min_m;
  scene.rain.box_max_m = Rain().box_max_m;
  const std::string message = message_of([&] { make_rain_space(scene); });
  EXPECT_NE(message.find("expected at most 20000000: a smaller box, culling_radius_m"),
            std::string::npos)
      << message;
  scene.rain.culling_radius_m = 15;
  scene.rain.local_height_m = 20;
  EXPECT_NEAR(make_rain_space(scene).expected_drops, 3 * std::numbers::pi * 225 * 20, 1);
}

TEST(RainSpace, TooDenseARainIsRefused) {
  Scene scene = wide_scene();
  scene.rain.sizes[0].drops_per_m3 = 1e13;
  scene.rain.box_min_m = {0, 1, 1.6};
  scene.rain.box_max_m = {0.001, 1.001, 1.601};
  const std::string message = message_of([&] { make_rain_space(scene); });
  EXPECT_NE(message.find("drops over a square metre; expected at most 5e+08"), std::string::npos)
      << message;
}

TEST(RainSpace, ACameraThatLooksAwayKeepsTheBoundToo) {
  Scene scene = wide_scene();
  scene.camera.position_m = {0, 100, 1.6};
  scene.camera.target_m = {0, 101, 1.6};
  EXPECT_LE(make_rain_space(scene).lost_share, scene.rain.lost_share);
}

TEST(FallFrame, IsTheWorldsForAFallStraightDownAndRightHandedForAny) {
  const FallFrame down = fall_frame({0, 0, -3});
  EXPECT_EQ(down.x, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(down.y, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(down.z, Eigen::Vector3d(0, 0, 1));
  for (const Eigen::Vector3d& v :
       {Eigen::Vector3d(5, 2, -1), Eigen::Vector3d(-90, 0, -1e-2), Eigen::Vector3d(0, 60, -4)}) {
    const FallFrame frame = fall_frame(v);
    EXPECT_LT((frame.z + v.normalized()).norm(), 1e-15);
    EXPECT_LT((frame.x.cross(frame.y) - frame.z).norm(), 1e-15);
    EXPECT_NEAR(frame.x.norm(), 1, 1e-15);
  }
}

}  // namespace
}  // namespace pluvia
