// Streaks under an environment map: what the renderer makes for it, and that frames are what the
// exact composite of the same coefficients is.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/fall_frame.h"
#include "raytrace/streak_geometry.h"
#include "raytrace/streak_placement.h"
#include "realtime/cumulative_atlas.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_renderer.h"
#include "tests/evening_sky.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"
#include "validate/frame_composite.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> resources_of(const FramePlan& plan, const std::string& pass) {
  std::vector<std::string> names;
  for (const PlannedPass& planned : plan.passes) {
    if (planned.name != pass) continue;
    for (const PlannedResource& resource : planned.resources) names.push_back(resource.name);
  }
  return names;
}

PlannedPass rain_of(const FramePlan& plan) {
  return *std::find_if(plan.passes.begin(), plan.passes.end(),
                       [](const PlannedPass& pass) { return pass.name == "rain"; });
}

TEST(Sky, WhatASceneDoesNotHaveCostsNothing) {
  PLUVIA_NEEDS_OPENGL();
  // The atlas's harmonics lie there all the same.
  const TemporaryFolder folder;
  Scene scene = rainy_scene(2000);
  RainRenderer uniform(scene, sky_atlas());
  StreakAtlas plain = sky_atlas();
  for (AtlasLayer& layer : plain.layers) layer.transfer.clear();
  plain.transfer_degree = -1;
  RainRenderer without_harmonics(scene, plain);
  EXPECT_EQ(uniform.streak_records(1).lit_per_streak, 3u);  // two lights and one for the sky
  EXPECT_TRUE(uniform.streak_records(1).sky.empty());
  EXPECT_EQ(uniform.render(1).color.values, without_harmonics.render(1).color.values);
  EXPECT_EQ(bytes_of(rain_of(uniform.plan())), bytes_of(rain_of(without_harmonics.plan())));
  for (const char* made : {"sky", "sky of streaks", "atlas: spans of the sky"})
    EXPECT_THAT(resources_of(uniform.plan(), "rain"), Not(Contains(made)));
  EXPECT_TRUE(rain_of(uniform.plan()).notes.empty());

  scene.environment = {};
  for (AtlasLayer& layer : plain.layers) layer.env.clear();
  RainRenderer dark(scene, plain);
  EXPECT_EQ(dark.streak_records(1).lit_per_streak, 2u);
  // A cell less of 76, and no array for harmonics.
  const LevelRange finest = {};
  EXPECT_EQ(76 * cumulative_atlas(plain, finest, 0).sums.size(),
            75 * cumulative_atlas(sky_atlas(), finest, 1).sums.size());
  EXPECT_TRUE(cumulative_atlas(sky_atlas(), finest, 1).sky_sums.empty());
}

TEST(Sky, AMapIsSeenInTheHarmonicsThatTheAtlasHas) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = evening_scene(folder, 2000);
  RainRenderer renderer(scene, sky_atlas());
  EXPECT_THAT(resources_of(renderer.plan(), "rain"), Contains("atlas: sums of the sky"));
  EXPECT_THAT(rain_of(renderer.plan()).shaders, Contains("rain_sky.glsl"));
  EXPECT_THAT(plan_text(renderer.plan()),
              HasSubstr("streaks see the sky in 16 spherical harmonics (degree 3)\n"));
  EXPECT_EQ(renderer.streak_records(1).lit_per_streak, 2u);

  // Asked for less; and an atlas that has none, which the plan says.
  RainRenderer mean(scene, sky_atlas(), {.sky_degree = 0});
  EXPECT_EQ(rain_of(mean.plan()).notes,
            (std::vector<std::string>{"streaks see the mean of the sky from everywhere"}));
  StreakAtlas plain = sky_atlas();
  for (AtlasLayer& layer : plain.layers) layer.transfer.clear();
  plain.transfer_degree = -1;
  RainRenderer fallen_back(scene, plain);
  EXPECT_THAT(costs_json(fallen_back.plan(), {}),
              HasSubstr("streaks see the mean of the sky from everywhere: the atlas has no "
                        "transfer pictures (transfer_degree in the preset)"));
  EXPECT_EQ(fallen_back.render(1).color.values, mean.render(1).color.values);
  EXPECT_EQ(message_of([&] { RainRenderer(scene, plain, {.sky_degree = 9}); }),
            "sky_degree = 9; expected 0 .. 8");
}

TEST(Sky, EveryStreakSeesItTurnedAsItsFormulaSays) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = evening_scene(folder, 20000);
  scene.camera.target_m = {1, 5, 2.4};  // views from below and from above
  RainRenderer renderer(scene, sky_atlas(), {.widest_splat_px = 0});  // thin ones leave no record
  const StreakRecords records = renderer.streak_records(1.25);
  ASSERT_EQ(records.sky.size(), records.streaks.size());
  std::size_t next = 0, over = 0;
  for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 1.25)) {
    const StreakGeometry geometry = streak_geometry(sky_atlas());
    const int segments = segment_times(scene.camera.exposure_s, drop.r0_m, geometry).count;
    for (int segment = 0; segment < segments && next < records.streaks.size(); ++segment) {
      const auto placed = place_streak(scene, drop, geometry, segment);
      const StreakRecord& record = records.streaks[next];
      if (!placed || std::abs(record.origin_px.x - placed->origin_px.x()) > 0.5 ||
          std::abs(record.depth_m - placed->depth_m) > 1e-4)
        continue;
      const SkyOfStreakRecord& sky = records.sky[next++];
      EXPECT_EQ(sky.size, drop.r0_m == scene.rain.sizes[0].r0_m ? 0 : 1);
      const FallFrame fall = fall_frame(drop.velocity_m_s);
      const Eigen::Vector3d x = placed->world_from_drop.col(0);
      // Nearly along the fall, the direction across it errs as a float's share of it.
      const double across = std::cos(placed->view_elevation_deg * std::numbers::pi / 180);
      EXPECT_NEAR(sky.cos_turn, x.dot(fall.x), 1e-6 / across);
      EXPECT_NEAR(sky.sin_turn, x.dot(fall.y), 1e-6 / across);
      if (std::abs(placed->view_elevation_deg) > 1e-3) {
        EXPECT_EQ(sky.transmitted, placed->view_elevation_deg < 0 ? -1 : 1);
      }
      over += sky.transmitted < 0 ? 1u : 0u;
    }
  }
  EXPECT_EQ(next, records.streaks.size());
  EXPECT_GT(over, 500u);
  EXPECT_GT(next - over, 500u);
}

double error_of(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options,
                int truth_degree) {
  RainRenderer renderer(scene, atlas, options);
  const Frame frame = renderer.render(1.25);
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 1.25);
  const FrameComposite truth =
      composite_frame(scene, atlas, drops, sky_of(scene, atlas, truth_degree), frame.background,
                      frame.depth_m, options.lookup);
  Image rain = frame.color;
  for (std::size_t i = 0; i < rain.values.size(); ++i) rain.values[i] -= frame.background.values[i];
  return relative_rmse(rain, truth.rain);
}

TEST(Sky, FramesUnderItAreTheExactCompositeOfTheSameHarmonics) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = evening_scene(folder, 3000);
  scene.lights.clear();  // nothing else shines
  // Every streak a quad. Bound as without a sky (realtime_composite_test.cpp): the mean field of
  // streaks over each other, and columns merged down to four, in each of which all harmonics share
  // one strip.
  const RenderOptions quads = {.widest_splat_px = 0};
  for (const int degree : {1, 2, 3}) {
    RenderOptions options = quads;
    options.sky_degree = degree;
    EXPECT_LT(error_of(scene, sky_atlas(), options, degree), 0.02) << degree;
  }
  RenderOptions nearest = quads;
  nearest.lookup = LookupMode::nearest;
  EXPECT_LT(error_of(scene, sky_atlas(), nearest, 3), 0.02);
  // Thin ones walked: 0.022 off with one cell for the sky, 0.068 here, where harmonics as large as
  // the uniform one make sums of both signs, whose light has no place of its own in a box; half as
  // much again. Traced ones, in street.toml: 0.014.
  EXPECT_LT(error_of(scene, sky_atlas(), {}, 3), 0.1);
  // And it tells degrees apart.
  EXPECT_GT(error_of(scene, sky_atlas(), {.sky_degree = 2}, 3), 0.1);
  EXPECT_GT(error_of(scene, sky_atlas(), {.sky_degree = 0}, 3), 0.1);
}

TEST(Sky, NoStreakIsDarkerThanBlack) {
  PLUVIA_NEEDS_OPENGL();
  // Harmonics of twenty times their size swing far below zero.
  StreakAtlas atlas = sky_atlas();
  for (AtlasLayer& layer : atlas.layers) {
    Image& finest = layer.transfer[0];
    for (int y = 0; y < finest.height; ++y) {
      for (int x = atlas.cell_width_px; x < finest.width; ++x) finest.at(x, y) *= 20;
    }
  }
  const TemporaryFolder folder;
  Scene scene = evening_scene(folder, 3000);
  scene.lights.clear();
  const Image rain = RainRenderer(scene, atlas).render(1.25).rain;
  EXPECT_GE(*std::min_element(rain.values.begin(), rain.values.end()), 0);
  // Cut where the exact composite cuts: the sum of a streak in a pixel. Half of the light cancels.
  EXPECT_LT(error_of(scene, atlas, {.widest_splat_px = 0}, 3), 0.04);
}

TEST(Sky, AllHarmonicsOfAColumnLieBetweenTheSameEdges) {
  const StreakAtlas& atlas = sky_atlas();
  const int views = static_cast<int>(atlas.views.size()), level = 1;
  const CumulativeAtlas sums = cumulative_atlas(atlas, {.finest = level, .coarsest = level}, 16);
  for (int view = 0; view < views; ++view) {
    const CumulativeSpan& span = sums.sky_spans[static_cast<std::size_t>(level * views + view)];
    const CellRect cell = cell_rect(atlas, view, 6, 0);  // the third of the second quad
    double sum = 0;
    for (int y = 0; y < cell.height; ++y) {
      for (int x = 2; x < 4; ++x)  // column 1 of merged ones
        sum += static_cast<double>(atlas.layers[3].transfer[0].at(cell.x + x, cell.y + y)) / 2;
    }
    const auto value = [&](int quad, int row, int harmonic) {
      const int place = span.first + (3 * 4 + quad) * span.cell_stride + (span.texels + 3) + row;
      return sums.sky_sums[static_cast<std::size_t>(4 * place + harmonic)];
    };
    EXPECT_NEAR(value(1, span.texels, 2), sum, 1e-4 * std::abs(sum));
    EXPECT_EQ(value(1, 0, 2), 0);
    for (int i = 0; i < 16; ++i) {
      EXPECT_EQ(value(i / 4, span.texels + 1, i % 4), value(0, span.texels + 1, 0)) << i;
      EXPECT_EQ(value(i / 4, span.texels + 2, i % 4), value(0, span.texels + 2, 0)) << i;
    }
    EXPECT_GT(value(0, span.texels + 2, 0), 0);
  }
}

TEST(Sky, AMirroredDropUnderAMirroredSkyIsTheMirroredStreak) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = rainy_scene(0);
  scene.lights.clear();
  scene.mesh = {};
  scene.camera.width_px = 161;
  scene.camera.position_m = {0, 0, 2};
  scene.camera.target_m = {0, 1, 2.2};
  const Image map = evening_map();
  Image mirrored = map;  // in the plane x = 0: longitude from +x, 180 degrees less
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const int to = (map.width / 2 - 1 - x + map.width) % map.width;
      for (int c = 0; c < 3; ++c) mirrored.at(to, y, c) = map.at(x, y, c);
    }
  }
  const auto rain_of = [&](const Image& sky, int oscillation) {
    scene.environment = {.map_file = folder / "map.exr"};
    write_exr(scene.environment.map_file, sky);
    scene.drops = {{.centre_m = {0, 0.5, 2.15}, .oscillation = oscillation}};
    return RainRenderer(scene, sky_atlas()).render(0).rain;
  };
  for (const int oscillation : {0, 2, 8}) {
    const Image one = rain_of(map, oscillation);
    const Image other = rain_of(mirrored, mirrored_oscillation(oscillation));
    const float most = *std::max_element(one.values.begin(), one.values.end());
    EXPECT_GT(most, 0) << oscillation;
    double difference = 0, asymmetry = 0;
    for (int y = 0; y < one.height; ++y) {
      for (int x = 0; x < one.width; ++x) {
        const float here = one.at(x, y);
        difference = std::max<double>(difference, std::abs(here - other.at(160 - x, y)));
        asymmetry = std::max<double>(asymmetry, std::abs(here - one.at(160 - x, y)));
      }
    }
    // Places in float: 1e-4 of a pixel, over which a streak one pixel wide changes by twice that.
    EXPECT_LT(difference, 1e-3 * most) << oscillation;
    EXPECT_GT(asymmetry, 0.01 * most) << oscillation << ": nothing was tested";
  }
}

}  // namespace
}  // namespace pluvia
