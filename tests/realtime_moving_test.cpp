// What a frame makes of surfaces that move.
#include <cmath>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "tests/moving_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

void expect_equal(const Frame& found, const Frame& expected, double time_s) {
  EXPECT_TRUE(found.color.values == expected.color.values) << time_s;
  EXPECT_TRUE(found.background.values == expected.background.values) << time_s;
  EXPECT_TRUE(found.rain.values == expected.rain.values) << time_s;
  EXPECT_TRUE(found.rain_tau.values == expected.rain_tau.values) << time_s;
  EXPECT_TRUE(found.depth_m.values == expected.depth_m.values) << time_s;
  EXPECT_EQ(found.streaks_in_view, expected.streaks_in_view) << time_s;
  EXPECT_EQ(found.splash_strokes, expected.splash_strokes) << time_s;
}

// With all that hangs on surfaces: shadows of a lamp and the sun, fog and glow, splashes, rain of
// two falls.
Scene everything() {
  Scene scene = shelter_scene();
  scene.lights[0].shadow = true;
  scene.lights.push_back({.name = "sun", .kind = LightKind::sun, .shadow = true});
  scene.lights.back().direction = Eigen::Vector3d(0.3, 0.4, -0.9).normalized();
  scene.lights.back().illuminance_lux = {10, 10, 10};
  scene.fog = Fog{.extinction_per_m = 0.02};
  scene.glow = Glow{};
  scene.splashes.emplace();
  scene.rain.sizes.push_back({.r0_m = 1e-3, .drops_per_m3 = 1, .velocity_m_s = {2, 1, -6}});
  return scene;
}

// The surfaces there at that time, to a renderer that knows of no movement: the ground holds the
// whole path, so that grids, maps and durations are the same. The fast part crosses 40 m in 50 ms.
TEST(Moving, AFrameIsThatOfSurfacesThatStandThereBitForBit) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = everything();
  Mesh fast = roof_of(2, 1, 3);
  add_moving_part(scene, fast, {{1, {-20, 6, 0}}, {1.05, {20, 6, 0}, 100}});
  RainRenderer renderer(scene, quarter_atlas());
  // Before the first key, in the picture, the same again, fast, gone, back.
  for (const double time_s : {0.0, 1.0, 1.0, 1.02, 2.4, 7.0, 0.9}) {
    const Frame found = renderer.render(time_s);
    pose(scene, time_s);
    const Frame fresh = RainRenderer(scene, quarter_atlas()).render(time_s);
    expect_equal(found, fresh, time_s);
    const Frame standing = RainRenderer(standing_scene(scene), quarter_atlas()).render(time_s);
    expect_equal(found, standing, time_s);
    EXPECT_GT(found.splash_strokes, 0) << time_s;
  }
}

TEST(Moving, APartAtTheCameraIsDrawnToo) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = shelter_scene();
  scene.moving.clear();
  scene.mesh = rainy_scene(0).mesh;
  const Eigen::Vector3d at = scene.camera.position_m;
  // A roof just above the camera, then through it, then a little below.
  add_moving_part(
      scene, roof_of(3, 2, 0),
      {{0, at + Eigen::Vector3d(0, 0, 0.02)}, {1, at}, {2, at - Eigen::Vector3d(0, 0, 0.02)}});
  RainRenderer renderer(scene, quarter_atlas());
  for (const double time_s : {0.0, 1.0, 2.0}) {
    const Frame found = renderer.render(time_s);
    EXPECT_TRUE(all_finite(found.color));
    pose(scene, time_s);
    expect_equal(found, RainRenderer(standing_scene(scene), quarter_atlas()).render(time_s),
                 time_s);
  }
}

// Rain in a box of 2 x 1 m, lower than the roof and narrower than it is.
TEST(Moving, NoDropIsDrawnUnderTheRoofAndAllAreOnceItHasPassed) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = shelter_scene();
  scene.rain.box_min_m = {-1, 3.5, 0};
  scene.rain.box_max_m = {1, 4.5, 2};
  scene.rain.sizes[0].drops_per_m3 = 500;
  RainRenderer renderer(scene, quarter_atlas(), {.packets = {.scheme = PacketScheme::world}});
  for (const double time_s : {0.0, 1.0, 1.01, 2.0, 0.99, 8.0}) {
    pose(scene, time_s);
    long drawn = 0;
    const auto drops = drop_field(scene, make_rain_space(scene), 10, time_s);
    for (const Drop& drop : drops) drawn += drop.hit_time_s > 0;
    const bool sheltered = std::abs(time_s - 1) < 0.02;
    EXPECT_EQ(drawn, sheltered ? 0 : static_cast<long>(drops.size())) << time_s;
    const long in_view = renderer.render(time_s).streaks_in_view;
    EXPECT_LE(in_view, drawn) << time_s;
    EXPECT_GE(in_view, drawn / 2) << time_s;
    const std::vector<float> centres = renderer.drop_centres_m(time_s);
    ASSERT_EQ(centres.size(), 3 * drops.size());
    double worst_m = 0;
    for (std::size_t i = 0; i < centres.size(); ++i)
      worst_m = std::max(worst_m, std::abs(static_cast<double>(centres[i]) -
                                           drops[i / 3].centre_m[static_cast<int>(i % 3)]));
    EXPECT_LT(worst_m, 1e-3) << time_s;
  }
}

TEST(Moving, ASceneInWhichNothingMovesHasNoByteAndNoPassOfIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = everything();
  RainRenderer moving(scene, quarter_atlas()), standing(standing_scene(scene), quarter_atlas());
  const auto passes = [](const Frame& frame) {
    std::string names;
    for (const PassCost& cost : frame.costs)
      names += cost.pass + (cost.skipped.empty() ? "" : " (" + cost.skipped + ")") + ", ";
    return names;
  };
  const Frame still = standing.render(0);
  EXPECT_EQ(passes(still), "surfaces, fog, rain, splashes, composite, ");
  EXPECT_EQ(passes(moving.render(0)), "moving surfaces (nothing has moved), " + passes(still));
  // Nor has one in which something does: it is what is there that changes.
  EXPECT_EQ(plan_text(moving.plan()), plan_text(standing.plan()));
  EXPECT_EQ(passes(moving.render(1)), "moving surfaces, " + passes(still));
}

}  // namespace
}  // namespace pluvia
