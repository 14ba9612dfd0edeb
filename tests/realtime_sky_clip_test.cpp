// A sky that changes: each frame under the map of its time, as if that stood still.
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raytrace/moving_parts.h"
#include "raytrace/sky_light.h"
#include "realtime/rain_renderer.h"
#include "tests/evening_sky.h"

namespace pluvia {
namespace {

using testing::Contains;
using testing::HasSubstr;

// The evening at three times: turned, brighter, of other colours.
Image evening_at(int k) {
  const Image evening = evening_map();
  Image map = evening;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) =
            static_cast<float>(1 + k) * evening.at((x + 9 * k) % map.width, y, (c + k) % 3);
    }
  }
  return map;
}

std::string map_name(const TemporaryFolder& folder, int k) {
  return folder / fmt::format("sky_{}.exr", k);
}

// Two maps a second from 0.1 s on.
Scene under_clip(const TemporaryFolder& folder, double drops = 1000) {
  Scene scene = evening_scene(folder, drops);
  for (int k = 0; k < 3; ++k) write_exr(map_name(folder, k), evening_at(k));
  scene.environment.map_file = folder / "sky_*.exr";
  scene.environment.frames_per_s = 2;
  scene.environment.start_s = 0.1;
  return scene;
}

Scene under_map(Scene scene, const std::string& file) {
  scene.environment = {.map_file = file, .scale_cd_m2 = scene.environment.scale_cd_m2};
  return scene;
}

void expect_same(const Frame& found, const Frame& expected, const std::string& what) {
  EXPECT_EQ(found.background.values, expected.background.values) << what;
  EXPECT_EQ(found.rain.values, expected.rain.values) << what;
  EXPECT_EQ(found.color.values, expected.color.values) << what;
}

TEST(SkyClip, EachFrameIsThatOfItsMapStandingStill) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene foggy = under_clip(folder);
  foggy.fog = Fog{.extinction_per_m = 0.05};
  foggy.splashes.emplace();
  const RenderOptions choices[] = {
      {}, {.widest_splat_px = 0}, {.look = StreakLook::sphere}, {.sky_degree = 0}};
  for (const RenderOptions& options : choices) {
    RainRenderer renderer(foggy, sky_atlas(), options);
    // Before it begins, its three maps, and the last one held; back and forth.
    for (const auto& [time_s, k] :
         {std::pair{0.0, 0}, {0.59, 0}, {1.2, 2}, {0.6, 1}, {7.0, 2}, {0.2, 0}}) {
      RainRenderer still(under_map(foggy, map_name(folder, k)), sky_atlas(), options);
      expect_same(renderer.render(time_s), still.render(time_s), fmt::format("{} s", time_s));
    }
  }
}

TEST(SkyClip, AFrameAloneIsTheFrameOfASequence) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = under_clip(folder);
  RainRenderer renderer(scene, sky_atlas());
  for (const double time_s : {0.1, 0.6, 1.1})
    expect_same(renderer.render(time_s), RainRenderer(scene, sky_atlas()).render(time_s), "alone");
}

TEST(SkyClip, AMapOfOneColourOrNoneTakesItsPlaceAmongOthers) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = under_clip(folder);
  Image grey = make_image(64, 32, 3);
  write_exr(map_name(folder, 0), grey);
  for (float& value : grey.values) value = 0.5f;
  write_exr(map_name(folder, 1), grey);
  for (const auto look : {StreakLook::traced, StreakLook::sphere}) {
    for (const int degree : {0, 3}) {
      const RenderOptions options = {.look = look, .sky_degree = degree};
      RainRenderer renderer(scene, sky_atlas(), options);
      Scene dark = scene;
      dark.environment = {};
      // A black sky adds nothing, not even by rounding.
      expect_same(renderer.render(0.2), RainRenderer(dark, sky_atlas(), options).render(0.2),
                  "black");
      expect_same(
          renderer.render(1.2),
          RainRenderer(under_map(scene, map_name(folder, 2)), sky_atlas(), options).render(1.2),
          "coloured");
      const Frame even = renderer.render(0.7);
      EXPECT_TRUE(all_finite(even.color));
      EXPECT_NE(even.color.values, renderer.render(0.2).color.values);
    }
  }
}

TEST(SkyClip, WhatAFrameDidAboutItIsInItsCosts) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = under_clip(folder, 300);
  RainRenderer renderer(scene, sky_atlas());
  const auto skipped = [&](double time_s) {
    for (const PassCost& cost : renderer.render(time_s).costs) {
      if (cost.pass == "sky") return cost.skipped;
    }
    return std::string("no pass");
  };
  EXPECT_EQ(skipped(0.6), "");
  EXPECT_EQ(skipped(0.7), "the same map");
  EXPECT_EQ(skipped(1.2), "");
  EXPECT_EQ(skipped(1.7), "the clip has ended: its last map is held");
  const FramePlan plan = renderer.plan();
  EXPECT_THAT(plan.passes.front().notes, Contains(HasSubstr("2 maps a second from 0.1 s on")));
  renderer.remake(under_map(scene, map_name(folder, 0)), sky_atlas(), {});
  EXPECT_EQ(skipped(0.6), "no pass");
}

TEST(SkyClip, ARendererMadeAnewGoesOnUnderIt) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = under_clip(folder, 1000);
  Scene lit = scene;
  lit.lights[0].intensity_cd *= 2;
  RainRenderer renderer(scene, sky_atlas());
  renderer.render(1.2);
  renderer.remake(lit, sky_atlas(), {});
  expect_same(renderer.render(1.2), RainRenderer(lit, sky_atlas()).render(1.2), "held");
  renderer.remake(scene, sky_atlas(), {});
  expect_same(renderer.render(0.2), RainRenderer(scene, sky_atlas()).render(0.2), "back");
}

TEST(SkyClip, RainOverAPictureFollowsIt) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = under_clip(folder, 1000);
  Picture picture = {make_image(160, 120, 3), make_image(160, 120)};
  for (float& value : picture.depth_m.values) value = 50;
  const auto frame_of = [&](const Scene& shown, double time_s) {
    RainRenderer renderer(shown, sky_atlas(), {.over_picture = true});
    renderer.show(picture);
    return renderer.render(time_s);
  };
  expect_same(frame_of(scene, 0.7), frame_of(under_map(scene, map_name(folder, 1)), 0.7),
              "picture");
}

TEST(SkyClip, ASceneIsPosedAtTheMapOfItsTime) {
  const TemporaryFolder folder;
  const Scene scene = under_clip(folder, 1);
  const std::pair<double, int> times[] = {{0, 0}, {0.6, 1}, {0.5999999, 1}, {0.59, 0}, {9, 2}};
  for (const auto& [time_s, k] : times) {
    const Scene posed = scene_at(scene, time_s);
    EXPECT_EQ(posed_map(posed.environment)->values, evening_at(k).values) << time_s;
  }
  EXPECT_EQ(clip_picture(scene.environment, -5), 0);
  EXPECT_EQ(clip_picture({.frames_per_s = 1000}, 1e7), 10000000000L);
  EXPECT_FALSE(posed_map({}));
  // Frames at k / 24 s are those of the clip, whatever k / 24 is rounded to.
  for (long k = 0; k < 100000; ++k)
    ASSERT_EQ(clip_picture({.frames_per_s = 24, .start_s = 1}, 1 + static_cast<double>(k) / 24), k);
}

}  // namespace
}  // namespace pluvia
