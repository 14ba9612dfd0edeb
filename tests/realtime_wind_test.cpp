// Rain that wind moves by steps, on the GPU (realtime/wind_pass.h).
#include "realtime/wind_pass.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/rain_space.h"
#include "realtime/rain_renderer.h"
#include "tests/moving_fixture.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

WindPrimitive whirl() {
  return {.kind = WindKind::tornado,
          .position_m = {0.5, 5, 0},
          .strength = 60,
          .inflow = 0.1,
          .core_radius_m = 1,
          .height_m = 6};
}

// A wall across, rain of two sizes.
Scene windy_scene(double drops, const WindPrimitive& primitive = whirl()) {
  Scene scene = rainy_scene(drops);
  add_rectangle(scene.mesh, {-6, 8, 0}, {12, 0, 0}, {0, 0, 3}, {});
  scene.rain.wind = {primitive};
  RainSize small = scene.rain.sizes[0];
  small.r0_m = 1e-3;
  small.velocity_m_s = {0, 0, -6.5};
  scene.rain.sizes.push_back(small);
  scene.rain.wind_m_s = {2, 1, 0};
  for (RainSize& size : scene.rain.sizes) size.velocity_m_s += scene.rain.wind_m_s;
  return scene;
}

const PlannedPass* pass_of(const FramePlan& plan, const std::string& name) {
  for (const PlannedPass& pass : plan.passes) {
    if (pass.name == name) return &pass;
  }
  return nullptr;
}

bool has_shader(const PlannedPass& pass, const std::string& file) {
  return std::count(pass.shaders.begin(), pass.shaders.end(), file) > 0;
}

TEST(WindPlan, OnlyASceneWithPrimitivesHasAStateAndAShaderThatStepsIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene even = windy_scene(500);
  even.rain.wind.clear();
  const FramePlan closed = RainRenderer(even, quarter_atlas()).plan();
  EXPECT_FALSE(pass_of(closed, "wind"));
  EXPECT_TRUE(has_shader(*pass_of(closed, "rain"), "drops_closed.glsl"));
  EXPECT_FALSE(has_shader(*pass_of(closed, "rain"), "drops_moving.glsl"));
  EXPECT_FALSE(has_shader(*pass_of(closed, "rain"), "wind_drops.glsl"));
  const FramePlan moved = RainRenderer(windy_scene(500), quarter_atlas()).plan();
  ASSERT_TRUE(pass_of(moved, "wind"));
  EXPECT_TRUE(has_shader(*pass_of(moved, "wind"), "wind_step.comp"));
  EXPECT_TRUE(has_shader(*pass_of(moved, "rain"), "drops_moving.glsl"));
  EXPECT_FALSE(has_shader(*pass_of(moved, "rain"), "drops_closed.glsl"));
  Scene dry = windy_scene(500);
  dry.rain.sizes.clear();
  EXPECT_FALSE(pass_of(RainRenderer(dry, quarter_atlas()).plan(), "wind")) << "nothing to move";
}

double apart_m(const MovingDrop& a, const MovingDrop& b, const Eigen::Vector3d& box_m) {
  Eigen::Vector3d way = a.position_m - b.position_m;
  for (int i = 0; i < 2; ++i) way[i] -= std::round(way[i] / box_m[i]) * box_m[i];
  return way.norm();
}

// Of all drops the share that the GPU has elsewhere than the steps in double.
double strayed_share(const Scene& scene, double time_s) {
  Scene posed = scene;
  DropMotion motion = make_drop_motion(scene);
  move_drops(motion, posed, time_s);
  WindPass pass = make_wind_pass(scene);
  step_wind(pass, time_s);
  const std::vector<MovingDrop> found = read_moving_drops(pass);
  EXPECT_EQ(found.size(), motion.drops.size());
  double strayed = 0;
  long moved = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const MovingDrop& drop = motion.drops[i];
    const bool same = found[i].fall == drop.fall &&
                      (found[i].since_hit_s < 0) == (drop.since_hit_s < 0) &&
                      apart_m(found[i], drop, motion.around.size_m) < 1e-3 &&
                      (found[i].velocity_m_s - drop.velocity_m_s).norm() < 1e-2;
    strayed += same ? 0 : 1;
    moved += (drop.velocity_m_s - Eigen::Vector3d(2, 1, drop.velocity_m_s.z())).norm() > 1 ? 1 : 0;
  }
  EXPECT_GT(moved, 100) << "the whirl is felt";
  return strayed / static_cast<double>(found.size());
}

TEST(WindStep, TheGpuMovesDropsAsTheStepsInDoubleDo) {
  PLUVIA_NEEDS_OPENGL();
  GlContext context;
  // A float's rounding of 18 m is 1e-6 m a step, 60 steps: 1e-4 m. What hits or leaves the box
  // within that of the end of a step does so a step earlier or later: 60 steps, each with 1e-6 m of
  // 7 cm for each of two surfaces, and what it did since is elsewhere: 2e-3 of the drops.
  EXPECT_LT(strayed_share(windy_scene(4000), 0.5), 4e-3);
  Scene bouncing = windy_scene(4000);
  bouncing.rain.restitution = 0.5;
  EXPECT_LT(strayed_share(bouncing, 0.5), 4e-3);
}

TEST(WindStep, KeysAndMovingPartsAreFollowed) {
  PLUVIA_NEEDS_OPENGL();
  GlContext context;
  WindPrimitive vortex = whirl();
  vortex.path = {{.time_s = 0, .position_m = {-2, 3, 0}, .strength = 60},
                 {.time_s = 0.4, .position_m = {3, 6, 0}, .strength = -40}};
  Scene scene = windy_scene(3000, vortex);
  add_moving_part(scene, roof_of(3, 2, 2.2f), {{0, {-6, 4, 0}}, {1, {4, 4, 0}}});
  EXPECT_LT(strayed_share(scene, 0.3), 4e-3);
}

bool same_drops(const WindPass& a, const WindPass& b) {
  const std::vector<MovingDrop> x = read_moving_drops(a), y = read_moving_drops(b);
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const auto& p, const auto& q) {
    return p.position_m == q.position_m && p.velocity_m_s == q.velocity_m_s && p.fall == q.fall &&
           p.since_hit_s == q.since_hit_s;
  });
}

TEST(WindStep, ATimeHasTheSameBytesHoweverItIsReached) {
  PLUVIA_NEEDS_OPENGL();
  GlContext context;
  const Scene scene = windy_scene(2000);
  WindPass at_once = make_wind_pass(scene), by_frames = make_wind_pass(scene),
           back = make_wind_pass(scene);
  step_wind(at_once, 0.5);
  for (int frame = 1; frame <= 12; ++frame) step_wind(by_frames, frame / 24.0);
  EXPECT_EQ(step_wind(by_frames, 0.501), "no step since the last frame");
  step_wind(back, 0.9);
  EXPECT_FALSE(same_drops(at_once, back));
  step_wind(back, 0.5);
  EXPECT_TRUE(same_drops(at_once, by_frames));
  EXPECT_TRUE(same_drops(at_once, back));
}

TEST(WindStep, TheRendererDrawsTheDropsOfTheDropField) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = windy_scene(3000);
  const double time_s = 0.303;  // between two steps
  RainRenderer renderer(scene, quarter_atlas());
  const std::vector<float> found = renderer.drop_centres_m(time_s);
  const auto expected = drop_field(scene, make_rain_space(scene), 4, time_s);
  ASSERT_EQ(found.size(), 3 * expected.size());
  int strayed = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Eigen::Vector3d at(static_cast<double>(found[3 * i]),
                             static_cast<double>(found[3 * i + 1]),
                             static_cast<double>(found[3 * i + 2]));
    strayed += (at - expected[i].centre_m).norm() < 2e-3 ? 0 : 1;
  }
  EXPECT_LT(strayed, 4e-3 * static_cast<double>(expected.size()));
}

double sum(const Image& image) {
  double all = 0;
  for (const float value : image.values) all += static_cast<double>(value);
  return all;
}

TEST(WindFrame, InStillAirRainMovedByStepsIsAsDenseAsTheClosedForm) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(40000);
  const Frame closed = RainRenderer(scene, quarter_atlas()).render(0.6);
  scene.rain.wind = {{.kind = WindKind::vortex, .strength = 0}};
  const Frame moved = RainRenderer(scene, quarter_atlas()).render(0.6);
  // Some 5,000 streaks in view, but the nearest weigh most: as much as a few hundred alike would
  // vary, 6 %; 3 of that.
  EXPECT_NEAR(sum(moved.rain_tau) / sum(closed.rain_tau), 1, 0.18);
  EXPECT_NEAR(
      static_cast<double>(moved.streaks_in_view) / static_cast<double>(closed.streaks_in_view), 1,
      5 * std::sqrt(2.0 / static_cast<double>(closed.streaks_in_view)));
}

TEST(WindFrame, AreFiniteAndTheSameAtATimeWhateverCameBefore) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = windy_scene(20000);
  scene.splashes.emplace();
  RainRenderer one(scene, quarter_atlas()), other(scene, quarter_atlas());
  one.render(0.8);
  const Frame back = one.render(0.4), forth = other.render(0.4);
  EXPECT_TRUE(all_finite(back.color));
  EXPECT_EQ(back.color.values, forth.color.values);
  EXPECT_GT(back.streaks_in_view, 1000);
  EXPECT_GT(back.splash_strokes, 100);
  EXPECT_EQ(back.costs[0].pass, "wind");
}

}  // namespace
}  // namespace pluvia
