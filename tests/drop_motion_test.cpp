// Rain that moves by steps (raytrace/drop_motion.h).
#include "raytrace/drop_motion.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/moving_parts.h"
#include "raytrace/rain_space.h"

namespace pluvia {
namespace {

// 8 x 6 x 5 m of air.
Scene airy_scene(double drops_per_m3, const Eigen::Vector3d& wind_m_s = {0, 0, 0}) {
  Scene scene;
  scene.rain.wind_m_s = wind_m_s;
  scene.rain.sizes = {{.r0_m = 1.6e-3,
                       .drops_per_m3 = drops_per_m3,
                       .velocity_m_s = Eigen::Vector3d(0, 0, -8) + wind_m_s}};
  scene.rain.box_min_m = {-4, -3, 0};
  scene.rain.box_max_m = {4, 3, 5};
  // Calls for steps, and is felt nowhere.
  scene.rain.wind = {{.kind = WindKind::vortex, .strength = 0}};
  return scene;
}

void add_face(Mesh& mesh, const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
              const Eigen::Vector3f& b) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const Eigen::Vector3f& p : {corner, Eigen::Vector3f(corner + a),
                                   Eigen::Vector3f(corner + a + b), Eigen::Vector3f(corner + b)}) {
    mesh.positions_m.push_back(p);
    mesh.normals.push_back(a.cross(b).normalized());
  }
  for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
  mesh.materials.resize(1);
  mesh.triangle_material.resize(mesh.indices.size() / 3);
}

long falling_below_surfaces(const DropMotion& motion) {
  long count = 0;
  for (const MovingDrop& drop : motion.drops) {
    const Eigen::Vector3d at = motion.around.low_m + drop.position_m;
    const bool below = at.z() <= height_at(motion.around.top, at.x(), at.y());
    count += drop.since_hit_s < 0 && below ? 1 : 0;
  }
  return count;
}

TEST(DropMotion, InStillAirDropsStayEvenAndComeInAgainFromAbove) {
  Scene scene = airy_scene(25);
  DropMotion motion = make_drop_motion(scene);
  ASSERT_EQ(motion.drops.size(), 6000u);
  move_drops(motion, scene, 2.5);
  // Chi-square of 64 cells of the box: mean 63, standard deviation sqrt(126) = 11; 5 of them.
  std::array<double, 64> cells = {};
  for (const MovingDrop& drop : motion.drops) {
    EXPECT_GE(drop.fall, 3u) << "20 m are four times the box";
    EXPECT_EQ(drop.velocity_m_s, Eigen::Vector3d(0, 0, -8));
    const Eigen::Vector3d cell = 4 * drop.position_m.cwiseQuotient(motion.around.size_m);
    ASSERT_TRUE((cell.array() >= 0).all() && (cell.array() < 4).all()) << cell.transpose();
    const int index = (static_cast<int>(cell.z()) * 4 + static_cast<int>(cell.y())) * 4 +
                      static_cast<int>(cell.x());
    cells[static_cast<std::size_t>(index)] += 1;
  }
  double chi2 = 0;
  for (const double n : cells) chi2 += (n - 93.75) * (n - 93.75) / 93.75;
  EXPECT_LT(chi2, 63 + 5 * 11.3);
  EXPECT_GT(chi2, 63 - 5 * 11.3);
}

TEST(DropMotion, AnEvenWindCarriesDropsAsFarAsItGoes) {
  const Eigen::Vector3d wind(5, -2, 0.5);
  Scene scene = airy_scene(20, wind);
  DropMotion motion = make_drop_motion(scene);
  const DropMotion begin = motion;
  move_drops(motion, scene, 0.5);
  int compared = 0;
  for (std::size_t i = 0; i < motion.drops.size(); ++i) {
    const MovingDrop& drop = motion.drops[i];
    if (drop.fall > 0) continue;
    // Rounding of 60 sums.
    EXPECT_LT((drop.velocity_m_s - wind - Eigen::Vector3d(0, 0, -8)).norm(), 1e-12);
    Eigen::Vector3d went =
        drop.position_m - begin.drops[i].position_m - 0.5 * (wind + Eigen::Vector3d(0, 0, -8));
    went.x() -= std::round(went.x() / 8) * 8;  // around the box
    went.y() -= std::round(went.y() / 6) * 6;
    EXPECT_LT(went.norm(), 1e-12);
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

// Two walls from south to north and the ground: whatever comes in between them stays there.
Scene walled_scene() {
  Scene scene = airy_scene(10);
  add_face(scene.mesh, {-4, -3, 0.1f}, {8, 0, 0}, {0, 6, 0});
  for (const float x : {-3.98f, 0.01f}) {
    add_face(scene.mesh, {x, -3, 20}, {0.02f, 0, 0}, {0, 6, 0});
    add_face(scene.mesh, {x, -3, 0}, {0, 6, 0}, {0, 0, 20});
  }
  return scene;
}

TEST(DropMotion, NoDropPassesAWallInAMillionSteps) {
  long drop_steps = 0, walls_hit = 0;
  for (const double step_s : {motion_step_s, 0.1}) {
    for (const double restitution : {0.0, 0.6}) {
      Scene scene = walled_scene();
      scene.rain.restitution = restitution;
      scene.rain.wind = {{.kind = WindKind::uniform, .axis = {0.6, 0.8, 0}, .strength = 60},
                         {.kind = WindKind::vortex, .axis = {0.6, 0.8, 0}, .strength = 20}};
      scene.rain.wind[1].position_m = {0, 0, 2.5};
      DropMotion motion = make_drop_motion(scene);
      const MovingSize& size = motion.sizes[0];
      for (int i = 0; i < 110; ++i) {
        for (std::size_t k = 0; k < size.count; ++k) {
          const MovingDrop before = motion.drops[k];
          MovingDrop& drop = motion.drops[k];
          drop = stepped(before, static_cast<std::uint32_t>(k), size, motion.around, step_s);
          ASSERT_TRUE(drop.position_m.allFinite() && drop.velocity_m_s.allFinite());
          ++drop_steps;
          if (drop.fall != before.fall) continue;
          ASSERT_EQ(drop.position_m.x() > 4, before.position_m.x() > 4)
              << before.position_m.transpose() << " to " << drop.position_m.transpose();
          walls_hit += drop.since_hit_s == 0 && drop.position_m.z() > 0.2 ? 1 : 0;
        }
      }
      EXPECT_EQ(falling_below_surfaces(motion), 0);
    }
  }
  EXPECT_GE(drop_steps, 1000000);
  EXPECT_GT(walls_hit, 10000);
}

TEST(DropMotion, AnyWindAtAnyPlaceIsEndured) {
  Scene scene = airy_scene(1);
  for (const WindKind kind : {WindKind::source, WindKind::vortex, WindKind::tornado}) {
    WindPrimitive primitive = {.kind = kind, .inflow = 0.5, .core_radius_m = 0.1, .height_m = 5};
    primitive.strength = 60 * 0.1 / 0.1016;
    for (const double sign : {-1.0, 1.0}) {
      scene.rain.wind = {primitive};
      scene.rain.wind[0].strength *= sign;
      DropMotion motion = make_drop_motion(scene);
      // On the axis, and on the borders of the grid.
      motion.drops[0].position_m = {4, 3, 2.5};
      motion.drops[1].position_m = {0, 0, 0};
      motion.drops[2].position_m = motion.around.size_m;
      for (int i = 0; i < 400; ++i) {
        for (std::size_t k = 0; k < motion.drops.size(); ++k) {
          MovingDrop& drop = motion.drops[k];
          drop = stepped(drop, static_cast<std::uint32_t>(k), motion.sizes[0], motion.around, 0.1);
          ASSERT_TRUE(drop.position_m.allFinite() && drop.velocity_m_s.allFinite());
          ASSERT_LT(drop.velocity_m_s.norm(), 300);
          ASSERT_TRUE((drop.position_m.array() >= -1e-9).all());
          ASSERT_TRUE((drop.position_m.array() <= motion.around.size_m.array() + 1e-9).all());
        }
      }
    }
  }
}

TEST(DropMotion, ADropThatHasHitComesInAgainWhenItWouldHaveFallen) {
  Scene scene = airy_scene(10);
  add_face(scene.mesh, {-9, -9, 2}, {18, 0, 0}, {0, 18, 0});
  DropMotion motion = make_drop_motion(scene);
  MovingDrop drop = {.position_m = {1, 1, 2.5}, .velocity_m_s = {0, 0, -8}};
  int steps = 0;
  double hit_at_s = 0;
  for (; drop.fall == 0; ++steps) {
    drop = stepped(drop, 0, motion.sizes[0], motion.around);
    if (hit_at_s == 0 && drop.since_hit_s == 0) hit_at_s = (steps + 1) * motion_step_s;
  }
  EXPECT_NEAR(hit_at_s, 0.5 / 8, motion_step_s);
  EXPECT_NEAR(steps * motion_step_s, 2.5 / 8, 3 * motion_step_s);
  EXPECT_GT(drop.position_m.z(), 4.8);
}

TEST(DropMotion, ABounceKeepsTheShareOfTheSpeedThatItIsTold) {
  Scene scene = airy_scene(10);
  add_face(scene.mesh, {-9, -9, 1}, {18, 0, 0}, {0, 18, 0});
  scene.rain.restitution = 0.5;
  const DropMotion motion = make_drop_motion(scene);
  MovingDrop drop = {.position_m = {1, 1, 1.05}, .velocity_m_s = {0, 0, -8}};
  drop = stepped(drop, 0, motion.sizes[0], motion.around);
  EXPECT_LT(drop.since_hit_s, 0);
  EXPECT_NEAR(drop.velocity_m_s.z(), 4, 1e-12);
  EXPECT_NEAR(drop.position_m.z(), 1 + back_off_m, 1e-6);
}

bool same(const DropMotion& a, const DropMotion& b) {
  if (a.drops.size() != b.drops.size()) return false;
  for (std::size_t i = 0; i < a.drops.size(); ++i) {
    if (a.drops[i].position_m != b.drops[i].position_m ||
        a.drops[i].velocity_m_s != b.drops[i].velocity_m_s || a.drops[i].fall != b.drops[i].fall)
      return false;
  }
  return true;
}

Scene gusty_scene() {
  Scene scene = airy_scene(5);
  add_face(scene.mesh, {-9, -9, 0.5f}, {18, 0, 0}, {0, 18, 0});
  WindPrimitive vortex = {.kind = WindKind::vortex, .strength = 20};
  vortex.path = {{.time_s = 0, .position_m = {-2, 0, 0}, .strength = 20},
                 {.time_s = 1, .position_m = {2, 1, 0}, .strength = 40}};
  scene.rain.wind = {vortex};
  return scene;
}

TEST(DropMotion, ATimeHasTheSameDropsHoweverItIsReached) {
  Scene scene = gusty_scene();
  DropMotion at_once = make_drop_motion(scene), by_frames = at_once, back = at_once;
  move_drops(at_once, scene, 0.7);
  for (int frame = 1; frame <= 21; ++frame) move_drops(by_frames, scene, frame / 30.0);
  move_drops(back, scene, 1.1);
  EXPECT_FALSE(same(at_once, back));
  move_drops(back, scene, 0.7);
  EXPECT_TRUE(same(at_once, by_frames));
  EXPECT_TRUE(same(at_once, back));
  scene.rain.seed = 2;
  DropMotion other = make_drop_motion(scene);
  move_drops(other, scene, 0.7);
  EXPECT_FALSE(same(at_once, other));
}

TEST(DropMotion, AMovingRoofLeavesNoDropFallingBelowIt) {
  Scene scene = airy_scene(50);
  Mesh roof;
  add_face(roof, {-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
  add_moving_part(scene, roof, {{0, {-3, 0, 0}, 0}, {1, {3, 0, 0}, 45}});
  DropMotion motion = make_drop_motion(scene);
  for (int i = 1; i <= 30; ++i) {
    move_drops(motion, scene, i / 30.0);
    EXPECT_EQ(falling_below_surfaces(motion), 0) << i;
  }
  Scene standing = scene;
  pose(standing, 29 / 30.0);
  EXPECT_GT(height_at(motion.around.top, 2.8, 0), 1.9) << "it has come with the stage";
}

TEST(DropMotion, MoreDropsThanItsMostAreRefused) {
  const Scene scene = airy_scene(1e5);
  try {
    make_drop_motion(scene);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "rain: 2.4e+07 drops in the box, moved by wind; expected at most 2000000: a "
                 "smaller box or less rain");
  }
}

}  // namespace
}  // namespace pluvia
