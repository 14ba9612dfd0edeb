// Streaks that take the shape of strokes: as much light and coverage as without, elsewhere.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/stroke_coverage.h"
#include "raytrace/streak_geometry.h"
#include "realtime/rain_renderer.h"
#include "tests/frame_light.h"
#include "tests/frame_threads.h"
#include "tests/made_up_strokes.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::Contains;
using testing::HasSubstr;

StreakAtlas with_strokes(const StreakAtlas& atlas) {
  StreakAtlas shaped = atlas;
  shaped.strokes = strokes_of({beaded_stroke(), beaded_stroke(60, 0.02), flashing_stroke()});
  return shaped;
}

// One drop before the black, at the middle of the exposure depth_m away; one lamp far off.
Scene one_drop(double depth_m, double r0_m = 1.6e-3) {
  Scene scene;
  scene.camera = {.position_m = {0, 0, 0},
                  .target_m = {0, 3, 0},
                  .vertical_fov_deg = 2 * 57.29577951308232 * std::atan(0.12 / depth_m),
                  .width_px = 48,
                  .height_px = 96,
                  .exposure_s = 1.0 / 60,
                  .white_cd_m2 = 1};
  scene.lights = {{.name = "lamp", .position_m = {50, 50, 80}, .intensity_cd = {2e6, 1e6, 5e5}}};
  scene.drops = {{.centre_m = Eigen::Vector3d(0.003, depth_m, 0.01 + 8.49 / 120), .r0_m = r0_m}};
  return scene;
}

RenderOptions quads(StreakLook look = StreakLook::sphere) {
  return {.widest_splat_px = 0, .look = look, .background_share = {}};
}
RenderOptions walked(StreakLook look = StreakLook::sphere) {
  return {.widest_splat_px = 16, .look = look, .background_share = {}};
}

// Of a streak's coverage, no more than what it has in its densest pixel can hide itself there.
double densest(const Frame& frame) {
  const auto& tau = frame.rain_tau.values;
  return -std::expm1(-static_cast<double>(*std::max_element(tau.begin(), tau.end())));
}

TEST(Strokes, LightAndCoverageOfAStreakAreThoseOfThePlainOne) {
  PLUVIA_NEEDS_OPENGL();
  for (const double depth_m : {0.8, 3.0, 30.0}) {
    for (const auto look : {StreakLook::sphere, StreakLook::sphere_published, StreakLook::white}) {
      for (const RenderOptions& options : {quads(look), walked(look)}) {
        const Scene scene = one_drop(depth_m);
        const Frame plain = RainRenderer(scene, quarter_atlas(), options).render(0);
        const Frame shaped = RainRenderer(scene, with_strokes(quarter_atlas()), options).render(0);
        ASSERT_EQ(shaped.streaks_in_view, 1);
        // Quads: sums of floats down a column, 1e-5. Walked: the steps in a pixel hide each other
        // by half of what they cover there together at most.
        const bool walks = options.widest_splat_px > 0;
        const double tolerance =
            1e-5 + (walks ? 0.5 * std::max(densest(plain), densest(shaped)) + 1e-4 : 0);
        EXPECT_NEAR(covered(shaped) / covered(plain), 1, tolerance) << depth_m << " " << walks;
        EXPECT_NEAR(light(shaped, 1) / light(plain, 1), 1, tolerance) << depth_m << " " << walks;
        // And it is another picture.
        double off = 0;
        for (std::size_t i = 0; i < plain.rain_tau.values.size(); ++i)
          off +=
              static_cast<double>(std::abs(shaped.rain_tau.values[i] - plain.rain_tau.values[i]));
        EXPECT_GT(off, 0.1 * covered(plain));
      }
    }
  }
}

// What the plain streak of a drop covers, of what whole pictures would: the part of its last
// picture may hold more or less than its share of the time.
double plain_share(const StreakAtlas& atlas, const Scene& scene) {
  const SegmentTimes times =
      segment_times(scene.camera.exposure_s, scene.drops[0].r0_m, streak_geometry(atlas));
  const AtlasView& view = atlas.views[0];
  const CellRect cell = cell_rect(atlas, 0, 0, 0);
  const Image& picture = atlas.layers[0].coverage[0];
  const double left = scene.camera.exposure_s / times.each_s - (times.count - 1);
  const double end = view.path_top_row + left * (view.path_bottom_row - view.path_top_row);
  double all = 0, part = 0;
  for (int y = 0; y < cell.height; ++y) {
    double row = 0;
    for (int x = 0; x < cell.width; ++x)
      row += static_cast<double>(picture.at(cell.x + x, cell.y + y));
    all += row;
    part += row * std::clamp(end - y, 0.0, 1.0);
  }
  return (times.count - 1 + part / all) * times.each_s / scene.camera.exposure_s;
}

TEST(Strokes, OneStrokeIsTheStreakOfADropOfAnySizeAndExposure) {
  PLUVIA_NEEDS_OPENGL();
  double most_off = 0;
  for (const double r0_m : {0.5e-3, 0.9e-3, 2.5e-3}) {
    for (const double exposure_s : {1.0 / 60, 1.0 / 150}) {
      Scene scene = one_drop(30, r0_m);
      scene.camera.exposure_s = exposure_s;
      scene.drops[0].centre_m.z() = 8.49 / 2 * exposure_s;
      const double share = plain_share(quarter_atlas(), scene);
      most_off = std::max(most_off, std::abs(share - 1));
      const Frame plain = RainRenderer(scene, quarter_atlas(), quads()).render(0);
      RainRenderer renderer(scene, with_strokes(quarter_atlas()), quads());
      EXPECT_EQ(renderer.streak_records(0).streaks.size(), 1u) << r0_m;
      const Frame shaped = renderer.render(0);
      // Level to 0.14 degrees: 0.007 of the view at 20 degrees, whose cut picture differs by at
      // most 0.2.
      EXPECT_NEAR(covered(plain) / covered(shaped), share, 0.002) << r0_m << " " << exposure_s;
    }
  }
  EXPECT_GT(most_off, 0.02);  // or there is nothing to see
}

// Coverage by rows of the picture.
std::vector<double> rows_of(const Frame& frame) {
  std::vector<double> rows;
  const Image& tau = frame.rain_tau;
  for (int y = 0; y < tau.height; ++y) {
    double sum = 0;
    for (int x = 0; x < tau.width; ++x) sum -= std::expm1(-static_cast<double>(tau.at(x, y)));
    rows.push_back(sum);
  }
  return rows;
}

TEST(Strokes, PixelsDownAStreakFollowTheStroke) {
  PLUVIA_NEEDS_OPENGL();
  const int beads = 12;  // rows of the stroke, far fewer than pixels
  StreakStroke stroke = beaded_stroke(beads);
  StreakAtlas atlas = quarter_atlas();
  atlas.strokes = strokes_of({stroke});
  for (const RenderOptions& options : {quads(), walked()}) {
    const Scene scene = one_drop(3);
    const std::vector<double> rows = rows_of(RainRenderer(scene, atlas, options).render(0));
    // Upright and straight on: 96 pixels show 0.24 m; the path, and what the cell has beyond it,
    // margins of the picture's rows.
    const AtlasView& view = atlas.views[0];
    const double px_m = 96 / 0.24, path_px = 8.49 / 60 * px_m;
    const double margin_px = view.path_top_row * atlas.pixel_m * px_m;
    const double top_px = 48 - (0.01 + 8.49 / 120) * px_m - margin_px;
    const double length_px = path_px + 2 * margin_px;
    double all = 0, off = 0, sum = 0;
    std::vector<double> expected;
    for (int y = 0; y < 96; ++y) {
      double mean = 0;
      for (int k = 0; k < 64; ++k) {
        const double place = (y + (k + 0.5) / 64 - top_px) / length_px * beads - 0.5;
        if (place < -0.5 || place > beads - 0.5) continue;
        const int i = static_cast<int>(std::floor(place));
        const double share = place - i;
        const auto bead = [&](int j) { return j < 0 || j >= beads ? 0 : 1.2 + std::sin(0.7 * j); };
        mean += ((1 - share) * bead(i) + share * bead(i + 1)) / 64;
      }
      expected.push_back(mean);
      sum += mean;
    }
    for (const double row : rows) all += row;
    for (std::size_t y = 0; y < rows.size(); ++y)
      off += std::abs(rows[y] / all - expected[y] / sum);
    // The cell's height is rounded up to a texel (0.3 of 255 rows), its rows are 0.23 px long, and
    // walked bins an eighth of a pixel: a quarter of a pixel of 57 + ..., where the beads' steps
    // are up to 0.16 of their mean a pixel.
    EXPECT_LT(off, 0.04) << options.widest_splat_px;
  }
}

// A few drops of the rain, near enough to be quads.
Scene few_drops() {
  Scene scene = rainy_scene(400);
  scene.rain.sizes.push_back({.r0_m = 0.8e-3, .drops_per_m3 = 0.2, .velocity_m_s = {0, 0, -6}});
  return scene;
}

TEST(Strokes, ADropHasTheSameOscillationAndOneStrokeInEveryFrame) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = few_drops();
  scene.rain.sizes.pop_back();
  const RenderOptions options = quads();
  RainRenderer plain(scene, quarter_atlas(), options);
  const StreakAtlas atlas = with_strokes(quarter_atlas());
  RainRenderer shaped(scene, atlas, options);
  EXPECT_EQ(shapes_of_set(atlas), 1);
  std::vector<StreakStroke> many;
  for (int i = 0; i < 25; ++i) many.push_back(beaded_stroke(10 + i));
  StreakAtlas more = quarter_atlas();
  more.strokes = strokes_of(many);
  ASSERT_EQ(shapes_of_set(more), 3);
  RainRenderer thrice(scene, more, options);
  for (const double time_s : {0.5, 0.51}) {
    const auto expected = plain.streak_records(time_s).streaks;
    const auto found = shaped.streak_records(time_s).streaks;
    const auto finer = thrice.streak_records(time_s).streaks;
    ASSERT_EQ(found.size(), expected.size());
    ASSERT_EQ(finer.size(), expected.size());
    ASSERT_GT(found.size(), 50u);
    std::set<int> layers;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].level_layer >> 8, expected[i].level_layer >> 8);
      EXPECT_EQ((finer[i].level_layer >> 8) / 3, expected[i].level_layer >> 8);
      layers.insert(finer[i].level_layer >> 8);
    }
    EXPECT_GT(layers.size(), 20u);  // of 30, among 50 drops and more
  }
  // The same drop a hundredth of a second later.
  Scene single = one_drop(1.5);
  single.drops.push_back(single.drops[0]);
  single.drops[1].centre_m.x() += 0.02;
  RainRenderer two(single, more, options);
  for (const double time_s : {0.0, 0.002}) {
    const auto records = two.streak_records(time_s).streaks;
    ASSERT_EQ(records.size(), 2u);
    EXPECT_EQ(records[0].level_layer >> 8, 0);
    EXPECT_EQ(records[1].level_layer >> 8, 1);  // the second drop: the second shape of its set
  }
}

TEST(Strokes, AFrameAloneIsTheFrameOfASequence) {
  PLUVIA_NEEDS_OPENGL();
  const StreakAtlas atlas = with_strokes(quarter_atlas());
  const RenderOptions options = {.look = StreakLook::sphere};
  RainRenderer renderer(few_drops(), atlas, options);
  renderer.render(0.4);
  renderer.render(0.45);
  EXPECT_EQ(renderer.render(0.5).color.values,
            RainRenderer(few_drops(), atlas, options).render(0.5).color.values);
}

TEST(Strokes, ARendererMadeAnewForThemIsAsOneMadeForThem) {
  PLUVIA_NEEDS_OPENGL();
  const StreakAtlas atlas = with_strokes(quarter_atlas());
  const RenderOptions options = {.look = StreakLook::sphere};
  Scene quick = few_drops();
  quick.camera.exposure_s = 1.0 / 800;  // another bound of what a texel covers
  RainRenderer renderer(few_drops(), quarter_atlas(), options);
  for (const auto& [scene, used] :
       {std::pair{few_drops(), &atlas}, {quick, &atlas}, {few_drops(), &quarter_atlas()}}) {
    renderer.remake(scene, *used, options);
    EXPECT_EQ(renderer.render(0.5).color.values,
              RainRenderer(scene, *used, options).render(0.5).color.values);
  }
}

// The number of threads is read once in a process, so each runs this very test with a file to
// write.
TEST(Strokes, AFrameHasTheSameBytesForEveryNumberOfThreads) {
  PLUVIA_NEEDS_OPENGL();
  if (const char* file = file_of_rerun()) {
    std::ofstream out(file, std::ios::binary);
    const Frame frame = RainRenderer(rainy_scene(20000), with_strokes(quarter_atlas()),
                                     {.look = StreakLook::sphere})
                            .render(0.5);
    append_bytes(out, frame.color);
    return;
  }
  const std::vector<std::string> frames = bytes_of_reruns({1, 2});
  EXPECT_EQ(frames[0].size(), 160u * 120 * 3 * sizeof(float));
  EXPECT_TRUE(frames[0] == frames[1]);
}

TEST(Strokes, RainOverARainIsOfNumbersInEveryScene) {
  PLUVIA_NEEDS_OPENGL();
  Scene rain = few_drops();
  rain.drops = {{.centre_m = {0.3, -0.2, 1.7}}, {.centre_m = {0.3, 5, 4}}};
  rain.drops[1].velocity_m_s = {0, 8, 0};  // away from the eye: an axis of no width
  Scene fog = rain, lens = rain, shadows = rain, slow = rain, quick = rain;
  fog.fog = Fog{.extinction_per_m = 0.15};
  fog.splashes.emplace();
  lens.camera.depth_of_field = DepthOfField{.aperture_m = 0.1, .focus_m = 4};
  shadows.lights[0].shadow = true;
  slow.camera.exposure_s = 0.2;
  quick.camera.exposure_s = 1.0 / 800;
  StreakAtlas atlas = quarter_atlas();
  atlas.strokes = strokes_of({one_pixel(), flashing_stroke(), beaded_stroke()});
  for (const Scene* scene : {&rain, &fog, &lens, &shadows, &slow, &quick}) {
    const Frame frame = RainRenderer(*scene, atlas, {.look = StreakLook::sphere}).render(0.5);
    for (const Image* image : {&frame.color, &frame.rain, &frame.rain_tau})
      EXPECT_TRUE(all_finite(*image));
    EXPECT_GT(light(frame, 0), 0);
  }
}

TEST(Strokes, ThePlanSaysWhoseShapesStreaksHave) {
  PLUVIA_NEEDS_OPENGL();
  StreakAtlas atlas = with_strokes(quarter_atlas());
  atlas.strokes.found = 7;
  const FramePlan plan = RainRenderer(few_drops(), atlas, {.look = StreakLook::white}).plan();
  for (const PlannedPass& pass : plan.passes) {
    if (pass.name != "rain") continue;
    EXPECT_THAT(pass.notes, Contains(HasSubstr("shapes of the 3 longest of 7 strokes")));
  }
}

TEST(Strokes, LooksThatHaveAShapeOfTheirOwnRefuseThem) {
  PLUVIA_NEEDS_OPENGL();
  for (const auto look : {StreakLook::traced, StreakLook::refraction}) {
    EXPECT_THAT(message_of([&] {
                  RainRenderer(few_drops(), with_strokes(quarter_atlas()), {.look = look});
                }),
                HasSubstr("strokes: the look takes none; expected sphere"));
  }
}

}  // namespace
}  // namespace pluvia
