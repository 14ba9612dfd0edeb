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
  scene.lights[0].shadow = true;
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

TEST(RainOverAPicture, TakesNoShaderAndNoByteOfSurfaces) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(300);
  scene.environment.uniform_cd_m2 = {0, 0, 0};
  const auto bytes_and_shaders = [&](bool over_picture) {
    const RenderOptions options = {.over_picture = over_picture};
    return RainRenderer(scene, quarter_atlas(), options).plan();
  };
  const FramePlan over = bytes_and_shaders(true), drawn = bytes_and_shaders(false);
  ASSERT_EQ(over.passes.size(), drawn.passes.size());
  EXPECT_EQ(over.passes[0].name, "picture");
  EXPECT_EQ(over.passes[0].shaders, (std::vector<std::string>{"screen.vert", "picture.frag"}));
  EXPECT_EQ(drawn.passes[0].name, "surfaces");
  for (const std::string& shader : drawn.passes[0].shaders) EXPECT_NE(shader, "picture.frag");
  // Colour and its depth, 2 x 2 a pixel; distance and depth; what is given. 16, 4, 4, 4, 12 and 4
  // bytes.
  EXPECT_EQ(bytes_of(over.passes[0]), 160u * 120 * (4 * (16 + 4) + 4 + 4 + 12 + 4));
  for (std::size_t i = 1; i < over.passes.size(); ++i) {
    EXPECT_EQ(over.passes[i].shaders, drawn.passes[i].shaders);
    EXPECT_EQ(bytes_of(over.passes[i]), bytes_of(drawn.passes[i])) << over.passes[i].name;
  }
}

TEST(RainOverAPicture, FogVeilsItByItsDepth) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.fog = Fog{.extinction_per_m = 0.05};
  Picture picture = even_picture(scene.camera, 3, 10);
  for (int x = 0; x < 160; ++x) picture.depth_m.at(x, 0) = sky;
  const Frame frame = frame_over(scene, picture);
  const CameraFrame camera = camera_frame(scene.camera);
  for (int y = 0; y < 120; y += 7) {
    for (int x = 0; x < 160; x += 9) {
      double left = 0;  // of four samples
      for (const auto& [dx, dy] : {std::pair{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}})
        left += std::exp(-0.05 * 10 / camera.focal_px *
                         Eigen::Vector3d(x + dx - 80, y + dy - 60, camera.focal_px).norm()) /
                4;
      if (y == 0) left = 0;  // 1e6 m of it
      for (int c = 0; c < 3; ++c) {
        const double expected = 3 * left + scene.environment.uniform_cd_m2[c] * (1 - left);
        // Distances come back from a depth in floats, 1e-6 of 10 m at 0.05 / m, through exp.
        EXPECT_NEAR(static_cast<double>(frame.background.at(x, y, c)), expected, 1e-5)
            << x << ", " << y;
      }
    }
  }
}

Picture motley_picture(const Camera& camera) {
  Picture picture = even_picture(camera, 0, sky);
  for (std::size_t i = 0; i < picture.color.values.size(); ++i)
    picture.color.values[i] =
        static_cast<float>(0.1 + static_cast<double>((i * 2654435761u >> 7) % 1000) / 250);
  return picture;
}

TEST(Darkening, MixesColoursWithTheirLuminance) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.darkening = Darkening{.desaturation = 0.6, .brightness = 0.8};
  const Picture picture = motley_picture(scene.camera);
  const Frame frame = frame_over(scene, picture);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const auto was = [&](int c) { return static_cast<double>(picture.color.at(x, y, c)); };
      const double grey = 0.2126 * was(0) + 0.7152 * was(1) + 0.0722 * was(2);
      for (int c = 0; c < 3; ++c) {
        const double expected = 0.8 * (0.4 * was(c) + 0.6 * grey);
        // A dozen roundings of values up to 4.1.
        EXPECT_NEAR(static_cast<double>(frame.background.at(x, y, c)), expected,
                    12 * 0x1p-24 * 4.1);
      }
    }
  }
}

// The formula of realtime/blur_pass.h, in double.
double blurred(const Image& image, int x, int y, int c, double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  double sum = 0, weights = 0;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const double weight = std::exp(-(i * i + j * j) / (2 * sigma_px * sigma_px));
      weights += weight;
      sum += weight * static_cast<double>(image.at(std::clamp(x + i, 0, image.width - 1),
                                                   std::clamp(y + j, 0, image.height - 1), c));
    }
  }
  return sum / weights;
}

TEST(Blur, IsAGaussianOfThePicture) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  for (const double sigma_px : {0.7, 2.5}) {
    scene.blur = Blur{sigma_px};
    const Picture picture = motley_picture(scene.camera);
    const Frame frame = frame_over(scene, picture);
    for (int y = 0; y < 120; y += 7) {
      for (int x = 0; x < 160; ++x) {
        // 17 weights twice, each a rounding and two of the sum; values up to 4.1.
        EXPECT_NEAR(static_cast<double>(frame.background.at(x, y, 1)),
                    blurred(picture.color, x, y, 1, sigma_px), 2 * 3 * 17 * 0x1p-24 * 4.1)
            << x << ", " << y;
      }
    }
  }
}

TEST(WholeImage, AnEffectThatIsNotCalledForContributesNothing) {
  PLUVIA_NEEDS_OPENGL();
  const Scene bare = rainy_scene(300);
  const auto plan = [](const Scene& scene) { return RainRenderer(scene, quarter_atlas()).plan(); };
  const FramePlan without = plan(bare);
  Scene dark = bare, blurry = bare;
  dark.darkening.emplace();
  blurry.blur = Blur{2};
  for (const auto& [name, scene] : {std::pair{"darkening", dark}, {"blur", blurry}}) {
    const FramePlan with = plan(scene);
    ASSERT_EQ(with.passes.size(), without.passes.size() + 1) << name;
    EXPECT_EQ(with.passes[1].name, name);
    for (std::size_t i = 0; i < without.passes.size(); ++i) {
      const PlannedPass& same = with.passes[i == 0 ? 0 : i + 1];
      EXPECT_EQ(same.name, without.passes[i].name);
      EXPECT_EQ(same.shaders, without.passes[i].shaders);
      EXPECT_EQ(bytes_of(same), bytes_of(without.passes[i])) << name << " changes " << same.name;
    }
  }
}

TEST(WholeImage, WhatCannotBeSeenIsSkippedAndSaidSo) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.darkening = Darkening{};
  scene.blur = Blur{0.1};
  const Frame frame = RainRenderer(scene, StreakAtlas()).render(0);
  ASSERT_EQ(frame.costs.size(), 4u);
  EXPECT_EQ(frame.costs[1].skipped, "it leaves colours alone");
  EXPECT_EQ(frame.costs[2].skipped, "it is narrower than a pixel");
  const Frame bare = RainRenderer(rainy_scene(0), StreakAtlas()).render(0);
  EXPECT_EQ(frame.background.values, bare.background.values);
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
