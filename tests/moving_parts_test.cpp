// Parts of the surfaces that move: where they are, and what that does to the rain.
#include "raytrace/moving_parts.h"

#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene_tops.h"
#include "raytrace/splash_space.h"
#include "tests/moving_fixture.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

const std::string scenes = PLUVIA_SOURCE_DIR "/data/scenes/";

TEST(MovingParts, APartPassesItsKeysTurnedAsTheySay) {
  Scene scene;
  Mesh shape;
  add_rectangle(shape, {1, 0, 2}, {1, 0, 0}, {0, 1, 0}, {});
  add_rectangle(shape, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {});  // faces east
  add_moving_part(scene, shape, {{1, {10, 0, 0}, 0}, {2, {10, 5, 0}, 90}, {4, {0, 5, 1}, 90}});
  const auto corner_at = [&](double time_s) -> Eigen::Vector3f {
    pose(scene, time_s);
    return scene.mesh.positions_m[0];
  };
  EXPECT_EQ(corner_at(0), Eigen::Vector3f(11, 0, 2)) << "at rest before the first key";
  EXPECT_LT((corner_at(2) - Eigen::Vector3f(10, 6, 2)).norm(), 1e-6f);
  EXPECT_LT((corner_at(4) - Eigen::Vector3f(0, 6, 3)).norm(), 1e-6f);
  EXPECT_EQ(scene.mesh.normals[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_LT((scene.mesh.normals[4] - Eigen::Vector3f(0, 1, 0)).norm(), 1e-6f) << "now north";
  EXPECT_EQ(corner_at(1e7), corner_at(4)) << "and after the last";
  EXPECT_FALSE(pose(scene, 5)) << "nothing has moved";
  EXPECT_TRUE(pose(scene, 3));
  // Half-way between the first keys, which a smooth path passes with Hermite's weights: at the
  // first at rest, at the second with (-10, 5, 1) m / 3 s and 30 deg / s.
  pose(scene, 1.5);
  const double turn = (45 - 1.0 / 8 * 30) * std::numbers::pi / 180;
  const Eigen::Vector3d place = Eigen::Vector3d(10, 2.5, 0) - Eigen::Vector3d(-10, 5, 1) / 24;
  const Eigen::Vector3d expected = place + Eigen::Vector3d(std::cos(turn), std::sin(turn), 2);
  EXPECT_LT((scene.mesh.positions_m[0].cast<double>() - expected).norm(), 1e-5);
}

TEST(MovingParts, TheReachHoldsEveryPose) {
  Scene scene = shelter_scene();
  // Overshoots its keys: the control points stand for that.
  scene.moving[0].path = {
      {0, {0, 0, 0}, 0}, {0.1, {4, 1, 0}, 10}, {2, {4, 2, 1}, 370}, {3, {0, 0, 0}, 0}};
  const Bounds reach = reach_of(scene.moving[0]);
  const Bounds all = surface_bounds(scene);
  double farthest = 0;
  for (int i = -10; i < 330; ++i) {
    pose(scene, 0.01 * i);
    for (std::size_t v = resting_vertices(scene); v < scene.mesh.positions_m.size(); ++v) {
      const Eigen::Vector3d p = scene.mesh.positions_m[v].cast<double>();
      farthest = std::max(farthest, p.x());
      for (int c = 0; c < 3; ++c) {  // a float at 10 m: 1e-6 m
        ASSERT_GE(p[c], reach.low_m[c] - 1e-6);
        ASSERT_LE(p[c], reach.high_m[c] + 1e-6);
      }
    }
  }
  EXPECT_GT(farthest, 4 + std::hypot(1.5, 1)) << "beyond its keys";
  EXPECT_LE(all.low_m.x(), -30);
  EXPECT_GE(all.high_m.z(), reach.high_m.z());
}

bool same_texels(const TopHeight& a, const TopHeight& b) {
  return a.texels.size() == b.texels.size() && a.lowest_m == b.lowest_m && a.min_x_m == b.min_x_m &&
         a.texel_m == b.texel_m &&
         std::memcmp(a.texels.data(), b.texels.data(), a.texels.size() * sizeof(TopTexel)) == 0;
}

// Every time in any order, slanted rain, two parts over each other, one that leaves the rain's box.
TEST(MovingParts, AStepLeavesTheTopsAndBlocksThatARebuildMakes) {
  Scene scene = shelter_scene();
  scene.splashes.emplace();
  scene.rain.sizes.push_back({.r0_m = 1e-3, .drops_per_m3 = 1, .velocity_m_s = {3, 1, -6}});
  add_moving_part(scene, roof_of(1.5f, 0.7f, 2.5f),
                  {{0, {-40, 2, 0}}, {1, {0, 2, 0.5}, 40}, {2, {40, 3, 0}, 90}});
  RainSpace space = make_rain_space(scene);
  SplashSpace splashes = make_splash_space(scene, space);
  ASSERT_EQ(space.tops.size(), 2u);
  TexelRect largest;
  for (const double time_s : {0.3, 1.0, 1.05, 1.5, 0.0, 3.0, 0.97}) {
    pose(scene, time_s);
    for (std::size_t i = 0; i < space.tops.size(); ++i) {
      const std::vector<TexelRect> changed = move_top(scene, space.tops[i]);
      for (const TexelRect& rect : changed) EXPECT_FALSE(rect.empty());
      move_splashes(space.tops[i], changed, splashes.blocks[i]);
    }
    const RainSpace rebuilt = make_rain_space(scene);
    const SplashSpace remade = make_splash_space(scene, rebuilt);
    EXPECT_EQ(remade.duration_s, splashes.duration_s);
    for (std::size_t i = 0; i < space.tops.size(); ++i) {
      EXPECT_TRUE(same_texels(space.tops[i], rebuilt.tops[i])) << i << " at " << time_s << " s";
      const HeightBlocks &a = splashes.blocks[i], &b = remade.blocks[i];
      ASSERT_EQ(a.extents.size(), b.extents.size());
      EXPECT_EQ(0,
                std::memcmp(a.extents.data(), b.extents.data(), a.extents.size() * sizeof(Extent)));
      EXPECT_EQ(a.all.low_m, b.all.low_m);
      EXPECT_EQ(a.all.high_m, b.all.high_m);
    }
  }
}

// The tops of the same surfaces, none of them a moving part.
TEST(MovingParts, TheTopsAreThoseOfSurfacesThatStandThere) {
  Scene scene = shelter_scene();
  pose(scene, 1.2);
  RainSpace space = make_rain_space(scene);
  const RainSpace standing = make_rain_space(standing_scene(scene));
  EXPECT_TRUE(same_texels(space.tops[0], standing.tops[0]));
  pose(scene, 0);
  move_top(scene, space.tops[0]);
  EXPECT_FALSE(same_texels(space.tops[0], standing.tops[0]));
}

// The roof of shelter_scene: 3 x 2 m, 2.2 m high, along x at y = 4.
TEST(MovingParts, NoDropIsUnderTheRoofWhereverItIsAndTheyAreBackBehindIt) {
  Scene scene = shelter_scene();
  RainSpace space = make_rain_space(scene);
  for (const double time_s : {0.0, 0.8, 1.0, 1.2, 2.0, 9.0}) {
    pose(scene, time_s);
    move_top(scene, space.tops[0]);
    const Eigen::Vector3d roof =
        scene.mesh.positions_m[scene.moving[0].first_vertex].cast<double>() +
        Eigen::Vector3d(1.5, 1, 0);
    int under = 0, above = 0, where_it_was = 0;
    for (const Drop& drop : drop_field(scene, space, 10, time_s)) {
      const Eigen::Vector3d from = drop.centre_m - roof;
      const bool beside = std::abs(from.x()) > 1.5 || std::abs(from.y()) > 1;
      const bool drawn = drop.hit_time_s > 0;
      if (!beside && from.z() < 0) {
        ++under;
        EXPECT_FALSE(drawn) << drop.centre_m.transpose() << " at " << time_s << " s";
      }
      if (!beside && from.z() > 0) above += drawn;
      // Its place at 1 s, clear of its rim of one texel now.
      const bool once = std::abs(drop.centre_m.x()) < 1.4 && std::abs(drop.centre_m.y() - 4) < 0.9;
      const bool clear = std::abs(from.x()) > 1.6;
      if (once && clear && drop.centre_m.z() > 0 && drop.centre_m.z() < 2) {
        ++where_it_was;
        EXPECT_TRUE(drawn) << drop.centre_m.transpose() << " at " << time_s << " s";
      }
    }
    if (std::abs(roof.x()) < 4) {
      EXPECT_GT(under, 100) << time_s;
      EXPECT_GT(above, 100) << time_s;
    }
    if (time_s != 1.0) {
      EXPECT_GT(where_it_was, 20) << time_s;
    }
  }
}

TEST(MovingParts, SplashesSitOnThePart) {
  Scene scene = shelter_scene();
  scene.splashes.emplace();
  pose(scene, 1);
  const RainSpace space = make_rain_space(scene);
  int on_roof = 0, on_ground = 0;
  for (const Splash& splash : splash_field(scene, space, make_splash_space(scene, space), 1)) {
    const bool below = std::abs(splash.place_m.x()) < 1.5 && std::abs(splash.place_m.y() - 4) < 1;
    EXPECT_NEAR(splash.place_m.z(), below ? 2.2 : splash.place_m.z(), 1e-6);
    (splash.place_m.z() > 1 ? on_roof : on_ground) += 1;
  }
  EXPECT_GT(on_roof, 5);
  EXPECT_GT(on_ground, 50);
}

TEST(MovingParts, WithoutAnythingElseThePartIsTheSurface) {
  Scene scene = shelter_scene();
  const std::vector<MovingKey> path = {{0, {0, 4, 5e4}}, {1, {1, 4, 5e4}}};
  scene.mesh = {};
  scene.moving.clear();
  add_moving_part(scene, roof_of(3, 2, 2.2f), path);
  scene.rain.box_min_m.z() += 5e4;
  scene.rain.box_max_m.z() += 5e4;
  const RainSpace space = make_rain_space(scene);
  // Heights are told from there, so that floats are as fine as on the ground.
  EXPECT_NEAR(space.tops[0].lowest_m, 5e4 + 2.2, 1e-2);
  EXPECT_NEAR(height_at(space.tops[0], 0, 4), 5e4 + 2.2, 1e-2);
}

std::string refusal_of(const std::string& text) {
  const std::string file =
      scratch_file("s.toml", "[camera]\nposition_m = [0, 0, 1]\ntarget_m = [0, 1, 1]\n" + text);
  const std::string message = message_of([&] { read_scene(file); });
  return message.substr(std::min(message.size(), file.size() + 1));
}

TEST(MovingParts, MistakesInAPartAreRefused) {
  const std::string car = "[[moving]]\nfile = \"" + scenes + "car.gltf\"\n";
  const std::string first = "[[moving.key]]\ntime_s = 1\nposition_m = [0, 0, 0]\n";
  const std::string second = "[[moving.key]]\ntime_s = 1.0005\nposition_m = [0, 0, 0]\n";
  const std::string later = "[[moving.key]]\ntime_s = 2\nposition_m = [0, 0, 0]\n";
  EXPECT_EQ(refusal_of(car + first + later), "");
  EXPECT_EQ(refusal_of(car), "4:1: moving[0] has 0 [[moving.key]]; expected 2 or more");
  EXPECT_NE(refusal_of(car + first).find("moving[0] has 1 [[moving.key]]; expected 2 or more"),
            std::string::npos);
  EXPECT_EQ(
      refusal_of(car + first + second),
      "10:1: moving[0].key[1].time_s = 1.0005; expected 0.001 s or more after the one before");
  EXPECT_NE(refusal_of(car + first + "heading = 3\n").find("9:1: unknown key \"heading\""),
            std::string::npos);
  EXPECT_NE(
      refusal_of(car + "speed_m_s = 3\n" + first + later).find("6:1: unknown key \"speed_m_s\""),
      std::string::npos);
  EXPECT_NE(refusal_of("[[moving]]\n" + first + later).find("4:1: "), std::string::npos)
      << refusal_of("[[moving]]\n" + first + later);
  EXPECT_NE(refusal_of("[[moving]]\n" + first + later).find("file"), std::string::npos);
  const std::string empty = scratch_file(
      "empty.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{}]})");
  EXPECT_EQ(refusal_of("[[moving]]\nfile = \"empty.gltf\"\n" + first + later),
            "5:1: moving[0].file = \"empty.gltf\" has no triangle with an area; expected one or "
            "more");
}

TEST(MovingParts, TheShippedCarIsReadAndDrivesThroughTheRain) {
  Scene scene = read_scene(scenes + "car.toml");
  ASSERT_EQ(scene.moving.size(), 1u);
  RainSpace space = make_rain_space(scene);
  const double first_s = scene.moving[0].path.front().time_s;
  const double last_s = scene.moving[0].path.back().time_s;
  double lowest_m = 1e9;
  for (int i = 0; i <= 4; ++i) {
    pose(scene, first_s + (last_s - first_s) * i / 4);
    const Bounds reach = reach_of(scene.moving[0]);
    EXPECT_GT(reach.low_m.x(), -3.4) << "on the road";
    EXPECT_LT(reach.high_m.x(), 3.4);
    for (std::size_t v = resting_vertices(scene); v < scene.mesh.positions_m.size(); ++v)
      lowest_m = std::min(lowest_m, static_cast<double>(scene.mesh.positions_m[v].z()));
    move_top(scene, space.tops[0]);
    EXPECT_TRUE(same_texels(space.tops[0], make_rain_space(scene).tops[0]));
  }
  EXPECT_GT(lowest_m, -0.05) << "its wheels touch the road";
  EXPECT_LT(lowest_m, 0.02);
}

}  // namespace
}  // namespace pluvia
