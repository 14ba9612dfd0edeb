// Thin streaks without quads: their profiles, the lights that they look at, and the picture against
// the exact composite and against quads.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "realtime/light_candidates.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_renderer.h"
#include "realtime/rain_splat.h"
#include "realtime/streak_profiles.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

constexpr RenderOptions all_quads = {.widest_splat_px = 0};

TEST(LightCandidates, HoldTheNearestLightAndFewBeside) {
  const std::vector<Eigen::Vector3d> lights = light_vectors(quarter_atlas());
  const std::vector<std::uint32_t> table = light_candidates(lights);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  double looked_at = 0;
  constexpr int trials = 20000;
  for (int i = 0; i < trials; ++i) {
    Eigen::Vector3d d(normal(random), normal(random), normal(random));
    if (i % 5 == 0) d[i % 3] = 0;  // the folds of the octahedron
    if (d.norm() < 1e-6) continue;
    d.normalize();
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < lights.size(); ++k) {
      if ((lights[k] - d).norm() < (lights[nearest] - d).norm()) nearest = k;
    }
    const auto cell = static_cast<std::size_t>(candidates_cell(d));
    const auto* first = table.data() + table[cell];
    const auto* last = table.data() + table[cell + 1];
    EXPECT_TRUE(std::find(first, last, nearest) != last) << d.transpose();
    EXPECT_TRUE(std::is_sorted(first, last));
    looked_at += static_cast<double>(last - first) / trials;
  }
  EXPECT_LT(looked_at, 6);
}

TEST(LightCandidates, OneLightIsTheNearestToAll) {
  const std::vector<std::uint32_t> table = light_candidates({{0, 0, -1}});
  constexpr int cells = candidate_cells * candidate_cells;
  ASSERT_EQ(table.size(), static_cast<std::size_t>(2 * cells + 1));
  for (int i = 0; i < cells; ++i) EXPECT_EQ(table[table[static_cast<std::size_t>(i)]], 0u);
}

// The whole and the left half of a cell's rows [0, rows): flux, moment, square, as
// streak_profiles.h says.
std::array<double, 6> direct_sums(const Image& picture, const CellRect& cell, int rows) {
  std::array<double, 6> sums = {};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cell.width; ++x) {
      const double value = static_cast<double>(picture.at(cell.x + x, cell.y + y)) / cell.width;
      const double low = static_cast<double>(x) / cell.width - 0.5;
      const double high = static_cast<double>(x + 1) / cell.width - 0.5;
      // The mean of u^2 over the texel.
      const double square = (low * low + low * high + high * high) / 3;
      for (const std::size_t part : {0u, 3u}) {
        if (part == 3 && low + high > 0) continue;
        sums[part] += value;
        sums[part + 1] += value * (low + high) / 2;
        sums[part + 2] += value * square;
      }
    }
  }
  return sums;
}

TEST(StreakProfiles, AreTheSumsOfTheirCells) {
  const StreakAtlas& atlas = quarter_atlas();
  const StreakProfiles profiles = streak_profiles(atlas, 1, 1);
  const auto views = atlas.views.size();
  const auto cells = static_cast<int>(atlas.lights.size()) + 2;
  ASSERT_EQ(profiles.spans.size(), static_cast<std::size_t>(profiles.levels) * views);
  for (int level = 0; level < profiles.levels; ++level) {
    for (const int view : {0, 3}) {
      const ProfileSpan& span =
          profiles.spans[static_cast<std::size_t>(level) * views + static_cast<std::size_t>(view)];
      for (const int cell : {0, cells / 2, cells - 2, cells - 1}) {
        const CellRect rect = cell_rect(atlas, view, cell < cells - 2 ? cell : 0, 0);
        for (const int edge : {0, 1, span.bins / 2, span.bins}) {
          const auto expected = direct_sums(finest_cell(atlas, 2, cell, 1).picture, rect,
                                            std::min(edge << (1 + level), rect.height));
          const float* values = profiles.values.data() +
                                4 * (span.first + (2 * cells + cell) * span.cell_stride + 2 * edge);
          for (std::size_t i = 0; i < 6; ++i)
            EXPECT_NEAR(static_cast<double>(values[i + i / 3]), expected[i],
                        1e-6 * std::abs(expected[i]) + 1e-12)
                << "level " << level << ", cell " << cell << ", edge " << edge << ", value " << i;
        }
      }
    }
  }
}

// Of the rain alone.
double relative_rmse(const Frame& frame, const Image& truth) {
  double square = 0, all = 0;
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    const double rain = static_cast<double>(frame.color.values[i]) -
                        static_cast<double>(frame.background.values[i]);
    square += std::pow(rain - static_cast<double>(truth.values[i]), 2);
    all += std::pow(static_cast<double>(truth.values[i]), 2);
  }
  return std::sqrt(square / all);
}

TEST(ThinStreaks, AreTheExactCompositeWithinTheirBound) {
  PLUVIA_NEEDS_OPENGL();
  struct Rain {
    const char* name;
    Eigen::Vector3d velocity_m_s;
    double widest_px, bound;
  };
  // Quads are 0.002 off here. A box stands for what the glints of two lights and two views make of
  // a half, and light beside its line crosses a border of pixels where the line does: together
  // 0.015 upright, 0.022 nearly level, 0.03 where cells are up to three pixels wide. The bounds are
  // half as much again.
  for (const Rain& rain : {Rain{"upright", {0, 0, -8.49}, 1, 0.025},
                           {"slanted", {6, 2, -6}, 1, 0.025},
                           {"nearly level", {8, 1, -0.5}, 1, 0.035},
                           {"up to three pixels", {0, 0, -8.49}, 3, 0.045}}) {
    Scene scene = rainy_scene(1500);
    scene.rain.sizes[0].velocity_m_s = rain.velocity_m_s;
    const auto drops = drop_field(scene, make_rain_space(scene), 10, 0.5);
    RainRenderer quads(scene, quarter_atlas(), all_quads);
    const Frame plain = quads.render(0.5);
    const FrameComposite truth =
        composite_frame(scene, quarter_atlas(), drops, sky_of(scene, quarter_atlas(), 0),
                        plain.background, plain.depth_m);
    RainRenderer thin(scene, quarter_atlas(), {.widest_splat_px = rain.widest_px});
    const Frame frame = thin.render(0.5);
    EXPECT_EQ(frame.streaks_in_view, plain.streaks_in_view) << rain.name;
    EXPECT_LT(thin.streak_records(0.5).streaks.size(), quads.streak_records(0.5).streaks.size() / 2)
        << rain.name;
    EXPECT_LT(relative_rmse(frame, truth.rain), rain.bound) << rain.name;
    EXPECT_TRUE(all_finite(frame.color)) << rain.name;
  }
}

TEST(ThinStreaks, LookingDownTheFallTheyAreHardlyWorseThanQuads) {
  PLUVIA_NEEDS_OPENGL();
  // Their paths are short there, and a line stands for a disc: 0.035 off, quads 0.032, half as much
  // again allowed.
  Scene scene = rainy_scene(20000);
  scene.camera.position_m = {0.3, 1, 7};
  scene.camera.target_m = {0.3, 1, 0};
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0.5);
  RainRenderer renderer(scene, quarter_atlas());
  const Frame frame = renderer.render(0.5);
  ASSERT_GT(frame.streaks_in_view, 200);
  const FrameComposite truth =
      composite_frame(scene, quarter_atlas(), drops, sky_of(scene, quarter_atlas(), 0),
                      frame.background, frame.depth_m);
  EXPECT_LT(relative_rmse(frame, truth.rain), 0.05);
}

TEST(ThinStreaks, MoreLightsThanAreWalkedTogetherAddUp) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(1000);
  const std::vector<Light> two = scene.lights;
  scene.environment = {};
  const Frame few = RainRenderer(scene, quarter_atlas()).render(0.5);
  // The same lights, each as ten of a tenth.
  scene.lights.clear();
  for (int i = 0; i < 10; ++i) {
    for (Light light : two) {
      light.intensity_cd /= 10;
      scene.lights.push_back(light);
    }
  }
  const Frame many = RainRenderer(scene, quarter_atlas()).render(0.5);
  double difference = 0, all = 0;
  for (std::size_t i = 0; i < few.rain.values.size(); ++i) {
    difference += std::abs(static_cast<double>(few.rain.values[i] - many.rain.values[i]));
    all += static_cast<double>(few.rain.values[i]);
  }
  // Roundings by chance of three sums instead of one, and boxes of eight lights instead of two:
  // which lights share a box decides how wide it is.
  EXPECT_LT(difference / all, 0.01);
}

TEST(ThinStreaks, LightBeyondTheIntegersIsDrawnByQuadsBitForBit) {
  PLUVIA_NEEDS_OPENGL();
  // Of lamps that is known beforehand, streak by streak; of the sky when a sum overflows.
  Scene bright_lamps = rainy_scene(2000), bright_sky = rainy_scene(2000);
  for (Light& light : bright_lamps.lights) light.intensity_cd *= 1e8;
  bright_sky.environment.uniform_cd_m2 *= 1e10;
  for (const Scene& scene : {bright_lamps, bright_sky}) {
    const Frame frame = RainRenderer(scene, quarter_atlas()).render(0.5);
    const Frame quads = RainRenderer(scene, quarter_atlas(), all_quads).render(0.5);
    EXPECT_TRUE(all_finite(frame.color));
    EXPECT_EQ(frame.streaks_in_view, quads.streaks_in_view);
    EXPECT_TRUE(frame.color.values == quads.color.values);
  }
}

std::size_t profile_bytes(const FramePlan& plan) {
  for (const PlannedPass& pass : plan.passes) {
    for (const PlannedResource& resource : pass.resources) {
      if (resource.name == "thin streaks: profiles") return resource.bytes;
    }
  }
  return 0;
}

TEST(ThinStreaks, ArbitrarilyNarrowOnesMayBeAskedFor) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(1000);
  const Frame quads = RainRenderer(scene, quarter_atlas(), all_quads).render(0.5);
  const auto bytes = profile_bytes(RainRenderer(scene, quarter_atlas()).plan());
  for (const double widest_px : {1e-3, 1e-9, 5e-324}) {
    RainRenderer thin(scene, quarter_atlas(), {.widest_splat_px = widest_px});
    // No drop of the scene is so far away; the narrower, the fewer bins.
    EXPECT_TRUE(thin.render(0.5).color.values == quads.color.values) << widest_px;
    EXPECT_GT(profile_bytes(thin.plan()), 0u) << widest_px;
    EXPECT_LT(profile_bytes(thin.plan()), bytes) << widest_px;
  }
}

TEST(ThinStreaks, AreQuadsWhereTheSumsOfThePictureDoNotFit) {
  // Five integers of four bytes for each of 4 x 3 pixels: 240 bytes.
  const Camera camera = {.width_px = 4, .height_px = 3};
  EXPECT_EQ(why_all_quads(camera, 240), "");
  EXPECT_EQ(why_all_quads(camera, 239),
            "streaks are all quads: sums of 4 x 3 pixels need 240 bytes, of 239");
}

TEST(ThinStreaks, NothingIsMadeForThemWhereNoneIsAskedFor) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(1000);
  const auto mentions = [](const FramePlan& plan) {
    long count = 0;
    for (const PlannedPass& pass : plan.passes) {
      count += std::count(pass.shaders.begin(), pass.shaders.end(), "rain_splat.comp");
      for (const PlannedResource& resource : pass.resources)
        count += resource.name.find("thin streaks") == 0;
    }
    return count;
  };
  EXPECT_EQ(mentions(RainRenderer(scene, quarter_atlas(), all_quads).plan()), 0);
  EXPECT_EQ(mentions(RainRenderer(scene, quarter_atlas()).plan()), 5);
  EXPECT_THROW(RainRenderer(scene, quarter_atlas(), {.widest_splat_px = 17}), std::runtime_error);
  EXPECT_THROW(RainRenderer(scene, quarter_atlas(), {.widest_splat_px = -1}), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
