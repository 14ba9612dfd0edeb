// Rain over pictures with depths: the same rain as over surfaces, in layers that add up, with a
// list of its drops.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "raytrace/streak_geometry.h"
#include "realtime/drop_list.h"
#include "realtime/frame_layers.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

constexpr float sky = std::numeric_limits<float>::infinity();

Picture even_picture(const Camera& camera, float value, float depth_m) {
  Picture picture = {make_image(camera.width_px, camera.height_px, 3),
                     make_image(camera.width_px, camera.height_px)};
  std::fill(picture.color.values.begin(), picture.color.values.end(), value);
  std::fill(picture.depth_m.values.begin(), picture.depth_m.values.end(), depth_m);
  return picture;
}

Frame frame_over(const Scene& scene, const Picture& picture, double time_s = 0) {
  RainRenderer renderer(scene, quarter_atlas(), {.over_picture = true});
  renderer.show(picture);
  return renderer.render(time_s);
}

std::vector<ListedDrop> drops_over(const Scene& scene, const Image& depth_m, DropNumbers& numbers,
                                   double time_s = 0) {
  const auto drops = drop_field(scene, make_rain_space(scene), 10, time_s);
  return list_drops(scene, streak_geometry(quarter_atlas()), drops, depth_m, numbers);
}

// Before a camera that looks north; the drop falls through the middle of the picture in the middle
// of the exposure.
Scene one_drop_scene(double distance_m) {
  Scene scene = rainy_scene(0);
  scene.mesh = {};
  scene.camera.position_m = {0, 0, 1.6};
  scene.camera.target_m = {0, 5, 1.6};
  const double fall_m = 8.49 * scene.camera.exposure_s;
  scene.drops = {{.centre_m = {0, distance_m, 1.6 + fall_m / 2}}};
  return scene;
}

double sum_of(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(value);
  return sum;
}

TEST(RainOverAPicture, OfARenderedSceneIsTheRainOfTheScene) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(3000);
  scene.splashes.emplace();
  add_rectangle(scene.mesh, {-2, 6, 0}, {3, 0, 0}, {0, 0, 3}, {.base_color = {0.6, 0.3, 0.2}});
  const Frame drawn = RainRenderer(scene, quarter_atlas()).render(0.3);
  const Frame over = frame_over(scene, {drawn.background, drawn.depth_m}, 0.3);
  EXPECT_EQ(over.depth_m.values, drawn.depth_m.values);
  EXPECT_EQ(over.streaks_in_view, drawn.streaks_in_view);
  EXPECT_GT(over.splash_strokes, 0);
  long others = 0;
  for (std::size_t i = 0; i < over.rain.values.size(); ++i) {
    // The mean of four alike is rounded three times.
    EXPECT_NEAR(over.background.values[i], drawn.background.values[i],
                3 * 0x1p-24f * drawn.background.values[i]);
    others += over.rain.values[i] != drawn.rain.values[i] ? 1 : 0;
  }
  // Depths for the depth test are interpolated there and computed here, 1e-6 apart at most: rain as
  // near to a surface as that may be hidden by one and not by the other, of all rain over 10 m
  // about one part in 1e6.
  EXPECT_LE(others, static_cast<long>(over.rain.values.size() / 100000));
  EXPECT_GT(sum_of(over.rain), 0);
}

TEST(RainOverAPicture, ADropBehindItsDepthIsHiddenAndOneBeforeItIsSeen) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = one_drop_scene(3);
  for (const float depth_m : {2.99f, 3.01f, sky}) {
    const Picture picture = even_picture(scene.camera, 0.5f, depth_m);
    const Frame frame = frame_over(scene, picture);
    DropNumbers numbers;
    const auto listed = drops_over(scene, picture.depth_m, numbers);
    if (depth_m < 3) {
      EXPECT_EQ(frame.color.values, picture.color.values);
      EXPECT_EQ(sum_of(frame.rain_tau), 0);
      EXPECT_TRUE(listed.empty());
    } else {
      EXPECT_GT(sum_of(frame.rain_tau), 0);
      ASSERT_EQ(listed.size(), 1u);
      EXPECT_EQ(listed[0].shown_share, 1);
    }
  }
}

TEST(RainOverAPicture, IsHiddenPixelByPixel) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = one_drop_scene(3);
  Picture picture = even_picture(scene.camera, 0.5f, sky);
  const Frame open = frame_over(scene, picture);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 160; ++x) picture.depth_m.at(x, y) = 2;  // its upper half
  }
  const Frame half = frame_over(scene, picture);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x)
      EXPECT_EQ(half.rain_tau.at(x, y), y < 60 ? 0 : open.rain_tau.at(x, y)) << x << ", " << y;
  }
  DropNumbers numbers;
  const auto listed = drops_over(scene, picture.depth_m, numbers);
  ASSERT_EQ(listed.size(), 1u);
  // Of 33 instants the middle one is at the border, in the lower pixel or the upper.
  EXPECT_NEAR(listed[0].shown_share, 0.5, 0.5 / 33 + 1e-12);
}

TEST(FrameLayers, AddUpToTheFrame) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(20000);
  scene.splashes.emplace();
  const Frame frame = RainRenderer(scene, quarter_atlas()).render(0);
  const FrameLayers layers = frame_layers(frame);
  EXPECT_EQ(layers.background.values, frame.background.values);
  EXPECT_EQ(layers.rain.values, frame.rain.values);
  for (std::size_t i = 0; i < frame.color.values.size(); ++i) {
    const double coverage = static_cast<double>(layers.coverage.values[i / 3]);
    EXPECT_GE(coverage, 0);
    EXPECT_LT(coverage, 1);
    const double sum = (1 - coverage) * static_cast<double>(layers.background.values[i]) +
                       static_cast<double>(layers.rain.values[i]);
    EXPECT_EQ(layers.color.values[i], static_cast<float>(sum));
    // The renderer's own has exp as its driver rounds it: some units in the last place of T.
    EXPECT_NEAR(static_cast<double>(frame.color.values[i]), sum, 2e-6 * sum);
  }
}

TEST(RainMask, IsWhereCoverageReachesItsBound) {
  Image coverage = make_image(3, 1);
  coverage.values = {0.0099f, 0.0101f, 0.5f};
  EXPECT_EQ(rain_mask(coverage, 0.01).values, (std::vector<float>{0, 1, 1}));
}

TEST(DropList, HoldsWhatThePictureShows) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(300);
  scene.mesh = {};
  Picture picture = even_picture(scene.camera, 0.5f, sky);
  for (int y = 0; y < 120; ++y) {
    for (int x = 60; x < 90; ++x) picture.depth_m.at(x, y) = 4;
  }
  const Frame frame = frame_over(scene, picture);
  DropNumbers numbers;
  const auto listed = drops_over(scene, picture.depth_m, numbers);
  ASSERT_GT(listed.size(), 20u);
  Image near_one = make_image(160, 120);
  for (const ListedDrop& drop : listed) {
    // A cell of the atlas is wider than its drop, and a pixel is added for its border.
    const StreakGeometry geometry = streak_geometry(quarter_atlas());
    const double cell = geometry.cell_width_px * geometry.pixel_m / geometry.mean_radius_m;
    const double reach = 1 + cell * std::max(drop.start_width_px, drop.end_width_px);
    const auto low = drop.start_px.cwiseMin(drop.end_px).array() - reach;
    const auto high = drop.start_px.cwiseMax(drop.end_px).array() + reach;
    double tau = 0;
    for (int y = std::max(0, static_cast<int>(low.y())); y < std::min(120.0, high.y()); ++y) {
      for (int x = std::max(0, static_cast<int>(low.x())); x < std::min(160.0, high.x()); ++x) {
        near_one.at(x, y) = 1;
        tau += static_cast<double>(frame.rain_tau.at(x, y));
      }
    }
    EXPECT_GT(tau, 0) << "drop " << drop.id << " at " << drop.start_px.transpose();
  }
  for (std::size_t i = 0; i < near_one.values.size(); ++i)
    EXPECT_TRUE(near_one.values[i] > 0 || frame.rain_tau.values[i] == 0)
        << i % 160 << ", " << i / 160;
}

TEST(DropList, KnowsADropAgainInTheNextFrame) {
  const Scene scene = rainy_scene(3000);
  const Image depth_m = even_picture(scene.camera, 0, sky).depth_m;
  DropNumbers numbers;
  const auto before = drops_over(scene, depth_m, numbers, 1);
  const std::size_t known = numbers.size();
  const double later_s = 1.0 / 64;
  const auto after = drops_over(scene, depth_m, numbers, 1 + later_s);
  int again = 0;
  for (const ListedDrop& drop : after) {
    if (drop.id >= static_cast<int>(known)) continue;
    const auto same = std::find_if(before.begin(), before.end(),
                                   [&](const ListedDrop& old) { return old.id == drop.id; });
    ASSERT_NE(same, before.end());
    ++again;
    // Phases are 2^-32 of 7.5 m; centres some metres from the origin.
    EXPECT_LT((same->drop.centre_m + later_s * same->drop.velocity_m_s - drop.drop.centre_m).norm(),
              1e-8);
    EXPECT_EQ(same->drop.oscillation, drop.drop.oscillation);
  }
  EXPECT_GT(again, 100);
}

TEST(DropList, ProjectsTheEndsOfTheStreak) {
  const Scene scene = one_drop_scene(3);
  const Image depth_m = even_picture(scene.camera, 0, sky).depth_m;
  DropNumbers numbers;
  const auto listed = drops_over(scene, depth_m, numbers);
  ASSERT_EQ(listed.size(), 1u);
  const double focal_px = camera_frame(scene.camera).focal_px;
  const double fall_px = focal_px * 8.49 * scene.camera.exposure_s / 3;
  EXPECT_NEAR(listed[0].start_px.x(), 80, 1e-9);
  EXPECT_NEAR(listed[0].start_px.y(), 60 - fall_px / 2, 1e-9);
  EXPECT_NEAR(listed[0].end_px.y(), 60 + fall_px / 2, 1e-9);
  EXPECT_NEAR(listed[0].start_width_px, focal_px * 3.2e-3 / 3, 1e-9);
  EXPECT_NEAR(listed[0].end_camera_m.z(), 3, 1e-12);
}

}  // namespace
}  // namespace pluvia
