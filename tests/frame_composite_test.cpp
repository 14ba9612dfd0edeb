#include "validate/frame_composite.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "raytrace/streak_placement.h"

namespace pluvia {
namespace {

// An atlas of one layer whose cells are constant: `light` and `coverage` for each view.
StreakAtlas constant_atlas(std::vector<AtlasView> views, std::vector<float> light,
                           std::vector<float> coverage) {
  StreakAtlas atlas{.cell_width_px = 4,
                    .levels = 1,
                    .mean_radius_m = 1.6e-3,
                    .exposure_s = 1.0 / 60,
                    .fall_speed_m_s = 9,
                    .pixel_m = 0.01,
                    .lights = {{0, 90}}};
  int rows = 0;
  for (AtlasView& view : views) {
    view.row_px = rows;
    rows += view.height_px;
  }
  AtlasLayer layer{0, {make_image(4, rows)}, {make_image(4, rows)}, {make_image(4, rows)}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (int y = views[i].row_px; y < views[i].row_px + views[i].height_px; ++y) {
      for (int x = 0; x < 4; ++x) {
        layer.point[0].at(x, y) = light[i];
        layer.env[0].at(x, y) = 0.25f;
        layer.coverage[0].at(x, y) = coverage[i];
      }
    }
  }
  atlas.views = views;
  atlas.layers = {layer};
  return atlas;
}

// 15 rows of path and 2 + 3 beyond it.
constexpr AtlasView level_view{
    .elevation_deg = 0, .height_px = 20, .path_top_row = 2, .path_bottom_row = 17};

// A camera that looks north along the plane z = 0, one lamp east of it.
Scene dark_scene() {
  Scene scene;
  scene.camera.position_m = {0, 0, 0};
  scene.camera.target_m = {0, 1, 0};
  scene.camera.width_px = 81;
  scene.camera.height_px = 61;
  scene.lights = {{"lamp", {30, 10, 0}, {9000, 1800, 900}}};
  return scene;
}

// The middle of its path is straight ahead, `distance` away.
Drop drop_ahead(double distance_m, std::uint64_t id = 0) {
  return {.id = id,
          .centre_m = {0, distance_m, 9.0 / 120},
          .velocity_m_s = {0, 0, -9},
          .r0_m = 1.6e-3,
          .hit_time_s = 1e9};
}

Image constant_image(const Scene& scene, int channels, float value) {
  Image image = make_image(scene.camera.width_px, scene.camera.height_px, channels);
  for (float& v : image.values) v = value;
  return image;
}

FrameComposite composite(const Scene& scene, const StreakAtlas& atlas,
                         const std::vector<Drop>& drops, float wall_m = 1e30f,
                         const Eigen::Vector3d& environment = {0, 0, 0}) {
  return composite_frame(scene, atlas, drops, sky_light({.uniform_cd_m2 = environment}, nullptr, 0),
                         constant_image(scene, 3, 8), constant_image(scene, 1, wall_m));
}

double pixels_per_metre(const Scene& scene, double distance_m) {
  const double half = scene.camera.vertical_fov_deg / 2 * std::numbers::pi / 180;
  return scene.camera.height_px / 2.0 / std::tan(half) / distance_m;
}

TEST(FrameComposite, SignalOfOneDropIsIrradianceTimesTransferTimesArea) {
  const Scene scene = dark_scene();
  const StreakAtlas atlas = constant_atlas({level_view}, {0.5f}, {0});
  const Image rain = composite(scene, atlas, {drop_ahead(10)}, 1e30f, {3, 2, 1}).rain;
  double sum[3] = {};
  for (std::size_t i = 0; i < rain.values.size(); ++i) sum[i % 3] += rain.values[i];
  // 4 x 20 texels of 0.01 m; lamp at 30 m: E = I / 900; S = 1/2, S_env = 1/4.
  const double area = 80 * std::pow(0.01 * pixels_per_metre(scene, 10), 2);
  EXPECT_NEAR(sum[0] / area, 10 * 0.5 + 3 * 0.25, 6e-6);
  EXPECT_NEAR(sum[1] / area, 2 * 0.5 + 2 * 0.25, 2e-6);
  EXPECT_NEAR(sum[2] / area, 1 * 0.5 + 1 * 0.25, 1e-6);
}

TEST(FrameComposite, NearDropsLieOverFarOnesAndBehindWallsNothing) {
  const Scene scene = dark_scene();
  // Pixel (40, 30) is covered whole by both: the texels are 0.01 m, the streak 0.04 m x 0.2 m,
  // which is wider than 3 pixels at 1 m and at 1.5 m.
  const StreakAtlas atlas = constant_atlas({level_view}, {0.5f}, {0.5f});
  const std::vector<Drop> both = {drop_ahead(1, 0), drop_ahead(1.5, 1)};
  const auto signal = [](double distance) {  // S of the first channel
    return 0.5 * 9000 / (30 * 30 + (10 - distance) * (10 - distance));
  };
  const auto center = [&](float wall) {
    return composite(scene, atlas, both, wall).color.at(40, 30);
  };
  EXPECT_NEAR(center(9), 0.5 * (0.5 * 8 + signal(1.5)) + signal(1), 1e-5);
  EXPECT_NEAR(center(1.2f), 0.5 * 8 + signal(1), 1e-5);
  EXPECT_NEAR(center(0.5f), 8, 0);
  EXPECT_EQ(composite(scene, atlas, both, 9).drops_seen, 2);
  EXPECT_EQ(composite(scene, atlas, both, 1.2f).drops_seen, 1);
  EXPECT_EQ(composite(scene, atlas, both, 0.5f).drops_seen, 0);
  EXPECT_EQ(composite(scene, atlas, {both[1], both[0]}, 9).color.values,
            composite(scene, atlas, both, 9).color.values);
}

TEST(FrameComposite, StreaksAreWhereTheyAreSeenTheFarthestFirst) {
  const Scene scene = dark_scene();
  const StreakAtlas atlas = constant_atlas({level_view}, {0.5f}, {0.5f});
  const FrameComposite one = composite(scene, atlas, {drop_ahead(1)});
  ASSERT_EQ(one.streaks.size(), 1u);
  const StreakMask& mask = one.streaks[0];
  long touched = 0;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const bool marked = mask.touched[static_cast<std::size_t>(y * mask.width + x)];
      EXPECT_EQ(marked, one.rain.at(mask.x0 + x, mask.y0 + y) != 0) << x << ", " << y;
      touched += marked;
    }
  }
  const auto lit = std::count_if(one.rain.values.begin(), one.rain.values.end(),
                                 [](float value) { return value != 0; });
  EXPECT_EQ(3 * touched, lit);
  const auto both = composite(scene, atlas, {drop_ahead(1, 0), drop_ahead(1.5, 1)});
  ASSERT_EQ(both.streaks.size(), 2u);
  EXPECT_LT(both.streaks[0].width, both.streaks[1].width);
  EXPECT_TRUE(composite(scene, atlas, {drop_ahead(1)}, 0.5f).streaks.empty());
}

TEST(FrameComposite, BetweenTwoViewsFluxIsInterpolated) {
  Scene scene = dark_scene();
  scene.lights.clear();
  AtlasView high{.elevation_deg = 40, .height_px = 16, .path_top_row = 2, .path_bottom_row = 13};
  const StreakAtlas atlas = constant_atlas({level_view, high}, {0, 0}, {0.001f, 0.002f});
  // Seen from 10 degrees above: 3/4 of the level view, 1/4 of the high one.
  const double angle = 10 * std::numbers::pi / 180;
  Drop drop = drop_ahead(10);
  scene.camera.position_m = {0, 0, 10 * std::tan(angle)};
  scene.camera.target_m = {0, 10, 0};
  const auto placement = place_streak(scene, drop, {0.01, 4, atlas.exposure_s, 2});
  ASSERT_TRUE(placement.has_value());
  ASSERT_NEAR(placement->view_elevation_deg, 10, 1e-9);
  const Eigen::Vector2d column = placement->column_px, row = placement->row_px;
  const double texel = std::abs(column.x() * row.y() - column.y() * row.x());
  double sum = 0;  // of coverage: 8 c is missing from the background
  for (const float value : composite(scene, atlas, {drop}).rain.values) sum -= value / 24.0;
  const double expected = texel * 4 * (0.75 * 20 * 0.001 + 0.25 * 16 * 0.002);
  EXPECT_NEAR(sum / expected, 1, 1e-5);  // coverage in floats over a background of 8: 1e-6
}

TEST(FrameComposite, ALampOnTheLeftMirrorsThePicture) {
  Scene scene = dark_scene();
  StreakAtlas atlas = constant_atlas({level_view}, {0}, {0});
  for (int y = 0; y < 20; ++y) atlas.layers[0].point[0].at(3, y) = 1;  // bright on the right
  const Image right = composite(scene, atlas, {drop_ahead(2)}).rain;
  scene.lights[0].position_m.x() = -30;
  const Image left = composite(scene, atlas, {drop_ahead(2)}).rain;
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 81; ++x) {
      ASSERT_NEAR(left.at(x, y), right.at(80 - x, y), 1e-5) << x << ", " << y;
    }
  }
  EXPECT_GT(right.at(41, 30), 1);
  EXPECT_EQ(right.at(39, 30), 0);
}

TEST(FrameComposite, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = dark_scene();
  const StreakAtlas atlas = constant_atlas({level_view}, {0.5f}, {0.1f});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-2, 2);
  std::vector<Drop> drops;
  for (std::uint64_t id = 0; id < 1200; ++id) {
    drops.push_back(drop_ahead(8, id));
    drops.back().centre_m += Eigen::Vector3d(place(random), 3 * place(random), place(random));
  }
  const Image all = composite(scene, atlas, drops).color;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(composite(scene, atlas, drops).color.values, all.values);
}

TEST(FrameComposite, PicturesThatDoNotFitAreRefused) {
  const Scene scene = dark_scene();
  const StreakAtlas atlas = constant_atlas({level_view}, {0.5f}, {0.1f});
  const Image color = constant_image(scene, 3, 1), depth = constant_image(scene, 1, 1);
  const auto run = [&](const Image& background, const Image& depth_m, std::vector<Drop> drops) {
    composite_frame(scene, atlas, drops, {}, background, depth_m);
  };
  EXPECT_NO_THROW(run(color, depth, {}));
  EXPECT_THROW(run(depth, depth, {}), std::runtime_error);
  EXPECT_THROW(run(color, color, {}), std::runtime_error);
  EXPECT_THROW(run(color, make_image(81, 60), {}), std::runtime_error);
  Image bad = depth;
  bad.at(3, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(run(color, bad, {}), std::runtime_error);
  bad.at(3, 3) = std::numeric_limits<float>::infinity();
  EXPECT_NO_THROW(run(color, bad, {}));
  Drop stranger = drop_ahead(5);
  stranger.oscillation = 7;
  EXPECT_THROW(run(color, constant_image(scene, 1, 9), {stranger}), std::runtime_error);
}

TEST(FrameComposite, LightsThatCastShadowsAreRefused) {
  Scene scene = dark_scene();
  scene.lights[0].shadow = true;
  try {
    composite(scene, constant_atlas({level_view}, {1}, {0.1f}), {drop_ahead(3)});
    FAIL() << "no refusal";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "light \"lamp\" casts shadows; expected none: the composite does not "
                 "know them");
  }
}

}  // namespace
}  // namespace pluvia
