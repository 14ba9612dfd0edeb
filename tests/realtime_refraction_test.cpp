// Streaks that refract the scene by masks: model C of 2006, with all orders.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "atlas/image_io.h"
#include "raytrace/mask_set.h"
#include "raytrace/sphere_closed_form.h"
#include "realtime/rain_renderer.h"
#include "realtime/refraction_look.h"
#include "tests/evening_sky.h"
#include "tests/frame_light.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::Contains;
using testing::Not;

constexpr double pi = std::numbers::pi;

// Of the ten sets of 2006, seen level and from 40 degrees on either side.
RefractionMasks masks_of(const MaskSetOptions& options) {
  MaskSetCost cost;
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  return trace_mask_set(preset, options, cost);
}

const StreakAtlas& masked_atlas() {
  static const StreakAtlas atlas = [] {
    StreakAtlas made = sky_atlas();
    made.masks =
        masks_of({.size_px = 32, .phases = 4, .instants = 32, .view_elevations_deg = {-40, 0, 40}});
    return made;
  }();
  return atlas;
}

RenderOptions refracting(int samples = 10) {
  return {.widest_splat_px = 0,
          .look = StreakLook::refraction,
          .persistence_samples = samples,
          .capture_px = 64};
}

// One drop before the black, seen across 14 pixels, whole in the picture.
Scene one_drop(int oscillation = 0) {
  Scene scene;
  scene.camera = {.position_m = {0, 0, 0},
                  .target_m = {0, 3, 0},
                  .vertical_fov_deg = 4,
                  .width_px = 32,
                  .height_px = 916,
                  .exposure_s = 1.0 / 60,
                  .white_cd_m2 = 1};
  scene.drops = {{.centre_m = Eigen::Vector3d(0.001, 3, 0) - Eigen::Vector3d(0, 0, -8.49 / 120),
                  .oscillation = oscillation}};
  return scene;
}

TEST(Refraction, UnderAUniformSkyADropIsAsBrightAsTheSky) {
  PLUVIA_NEEDS_OPENGL();
  for (const int oscillation : {0, 6}) {
    Scene scene = one_drop(oscillation);
    scene.environment.uniform_cd_m2 = {30, 20, 10};
    for (const auto capture : {SceneCapture::cube, SceneCapture::wide}) {
      for (const double thin_px : {0.0, 16.0}) {
        RenderOptions options = refracting();
        options.capture = capture;
        options.widest_splat_px = thin_px;
        RainRenderer renderer(scene, masked_atlas(), options);
        const Eigen::Vector3d found = brightness(renderer.render(0));
        // Weights and tail are all the light: only halves (2^-11, to nearest) and the walk's
        // rounding of light and of coverage (1e-3, docs/rendering.md) are off.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(found[c] / scene.environment.uniform_cd_m2[c], 1, thin_px > 0 ? 2e-3 : 5e-4)
              << "set " << oscillation << ", thin " << thin_px;
      }
    }
  }
}

TEST(Refraction, AStreakCoversWhatItsOutlineDoes) {
  PLUVIA_NEEDS_OPENGL();
  // In all it covers the outline's area, whatever the samples; of a sphere pi r^2, in pixels.
  const Scene scene = one_drop();
  const double focal_px = 458 / std::tan(2 * pi / 180);
  const double expected = pi * std::pow(1.6e-3 / 3 * focal_px, 2);
  RainRenderer renderer(scene, masked_atlas(), refracting(50));
  // The polygon of 64 corners between which the outline is linear lacks (2 pi / 64)^2 / 6 = 1.6e-3;
  // what is left is the samples' own: a chord is cut into 50.
  EXPECT_NEAR(covered(renderer.render(0)) / expected, 1, 5e-3);
}

// A lamp seen through a sphere at that angle.
Scene lamp_behind(double angle_rad) {
  Scene scene = one_drop();
  Light sun{.name = "sun", .kind = LightKind::sun};
  const Eigen::Vector3d onward = Eigen::Vector3d(0.001, 3, 0).normalized();
  sun.direction =
      -(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(0.3, 0.02, 1).normalized()) * onward);
  sun.illuminance_lux = {500, 400, 300};
  scene.lights = {sun};
  return scene;
}

TEST(Refraction, ALampThroughASphereHasTheLightOfItsTransferFunction) {
  PLUVIA_NEEDS_OPENGL();
  // The mean of D over the lamp's cone, of orders 0 to 2 alone. The sphere's image of the lamp is
  // found by 50 samples of patches, whose area errs as sphere and mask (32 px) bend within them.
  for (const double angle : {0.3, 0.8, 1.2}) {
    const Scene scene = lamp_behind(angle);
    RainRenderer renderer(scene, masked_atlas(), refracting(50));
    const double d =
        sphere_intensity_in_cone(1.333, 2, angle, masked_atlas().masks.cone_half_angle_rad);
    const Eigen::Vector3d found = brightness(renderer.render(0));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found[c] / (d * scene.lights[0].illuminance_lux[c]), 1, 0.06) << angle;
  }
}

TEST(Refraction, ADropShowsTheSceneUpsideDown) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = one_drop();
  // Bright above, dark below; the drop stands still before it.
  Image map = make_image(64, 32, 3);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) map.at(x, y, c) = 1;
    }
  }
  scene.environment = {.map_file = folder / "half.exr", .scale_cd_m2 = 1};
  write_exr(scene.environment.map_file, map);
  scene.camera.exposure_s = 1e-6;
  scene.camera.height_px = 64;
  scene.camera.vertical_fov_deg = 0.28;
  scene.drops[0].centre_m = {0.0, 3, 0.0};
  RainRenderer renderer(scene, masked_atlas(), refracting(20));
  const Frame frame = renderer.render(0);
  double upper = 0, lower = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 32; ++x)
      (y < 32 ? upper : lower) += static_cast<double>(frame.rain.at(x, y));
  }
  // Of a sphere, straight refraction holds 0.89 of the light and bends all of it across the axis;
  // half of what is reflected or comes out later (0.11) may be on either side.
  const double half = covered(frame) / 2;
  EXPECT_GT(lower / half, 0.85);
  EXPECT_LT(upper / half, 0.15);
}

// A still drop 0.3 m before a camera of 100 degrees, under a blue sky.
Scene before_a_picture() {
  Scene scene = one_drop();
  scene.environment.uniform_cd_m2 = {0, 0, 1};
  scene.camera.exposure_s = 1e-6;
  scene.camera.width_px = scene.camera.height_px = 600;
  scene.camera.vertical_fov_deg = 100;
  scene.drops[0].centre_m = {0.0, 0.3, 0.0};
  return scene;
}

Frame over_red(const Scene& scene, int red_rows, SceneCapture capture) {
  Picture picture = {make_image(scene.camera.width_px, scene.camera.height_px, 3),
                     make_image(scene.camera.width_px, scene.camera.height_px)};
  for (int y = 0; y < red_rows; ++y) {
    for (int x = 0; x < scene.camera.width_px; ++x) picture.color.at(x, y, 0) = 1;
  }
  std::fill(picture.depth_m.values.begin(), picture.depth_m.values.end(), 10.0f);
  RenderOptions options = refracting(20);
  options.over_picture = true;
  options.capture = capture;
  options.capture_px = 512;  // of which a wide capture has but 80 for the picture
  RainRenderer renderer(scene, masked_atlas(), options);
  renderer.show(picture);
  return renderer.render(0);
}

TEST(Refraction, OverAPictureADropShowsItUpsideDownAndTheSkyBesideIt) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = before_a_picture();
  for (const auto capture : {SceneCapture::cube, SceneCapture::wide}) {
    // Red where the picture is, blue beside it: together all of the light.
    const Frame all = over_red(scene, 600, capture);
    const Eigen::Vector3d found = brightness(all);
    EXPECT_NEAR(found.x() + found.z(), 1, 1e-3);
    EXPECT_GT(found.x(), 0.6);
    EXPECT_GT(found.z(), 0.03);
    EXPECT_EQ(found.y(), 0);
    // Its upper half alone is in the lower half of the drop, as in ADropShowsTheSceneUpsideDown,
    // but for what straight refraction bends by more than the 50 degrees that the picture reaches
    // up: incidence of more than 70 degrees, 0.12 of the drop's face.
    const Frame half = over_red(scene, 300, capture);
    double upper = 0, lower = 0;
    for (int y = 0; y < 600; ++y) {
      for (int x = 0; x < 600; ++x)
        (y < 300 ? upper : lower) += static_cast<double>(half.rain.at(x, y, 0));
    }
    EXPECT_GT(lower / (covered(half) / 2), 0.85 - 0.12 - 0.06);
    EXPECT_LT(upper / (covered(half) / 2), 0.15);
  }
}

TEST(Refraction, OverAPictureOfTheSceneTheRainIsThatOfTheScene) {
  PLUVIA_NEEDS_OPENGL();
  // The capture has the picture's pixels, filtered, where it else has the surfaces themselves.
  const Scene scene = rainy_scene(300);
  RainRenderer plain(scene, masked_atlas(), refracting());
  const Frame expected = plain.render(0.5);
  RenderOptions options = refracting();
  options.over_picture = true;
  RainRenderer renderer(scene, masked_atlas(), options);
  renderer.show({expected.background, expected.depth_m});
  const Frame found = renderer.render(0.5);
  double square = 0, all = 0;
  for (std::size_t i = 0; i < found.rain.values.size(); ++i) {
    square += std::pow(static_cast<double>(found.rain.values[i] - expected.rain.values[i]), 2);
    all += std::pow(static_cast<double>(expected.rain.values[i]), 2);
  }
  ASSERT_GT(all, 0);
  EXPECT_LT(std::sqrt(square / all), 0.05);
}

TEST(Refraction, ManySamplesConverge) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = one_drop(6);
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(scene.environment.map_file, evening_map());
  const auto picture = [&](int samples) {
    return RainRenderer(scene, masked_atlas(), refracting(samples)).render(0).rain;
  };
  const Image many = picture(50);
  const auto error = [&](const Image& few) {
    double square = 0, all = 0;
    for (std::size_t i = 0; i < many.values.size(); ++i) {
      square += std::pow(static_cast<double>(few.values[i] - many.values[i]), 2);
      all += std::pow(static_cast<double>(many.values[i]), 2);
    }
    return std::sqrt(square / all);
  };
  const double one = error(picture(1)), five = error(picture(5)), twenty = error(picture(20));
  std::printf("1: %.3f, 5: %.3f, 10: %.3f, 20: %.3f\n", one, five, error(picture(10)), twenty);
  EXPECT_LT(five, one / 2);
  EXPECT_LT(twenty, five * 0.7);
}

// What the plan names.
std::vector<std::string> named(const FramePlan& plan) {
  std::vector<std::string> names;
  for (const PlannedPass& pass : plan.passes) {
    names.push_back(pass.name);
    names.insert(names.end(), pass.shaders.begin(), pass.shaders.end());
    for (const PlannedResource& resource : pass.resources) names.push_back(resource.name);
  }
  return names;
}

TEST(Refraction, ThePlanCountsEveryFaceAndLevelOfTheCapture) {
  PLUVIA_NEEDS_OPENGL();
  RenderOptions options = refracting();
  options.capture = SceneCapture::cube;
  options.capture_px = 64;
  const Scene scene = rainy_scene(100);
  RainRenderer renderer(scene, masked_atlas(), options);
  std::size_t texels = 0;
  for (int size = 64; size >= 1; size /= 2) texels += static_cast<std::size_t>(6 * size * size);
  for (const PlannedPass& pass : renderer.plan().passes) {
    for (const PlannedResource& resource : pass.resources) {
      if (pass.name == "surroundings" && resource.name == "picture") {
        EXPECT_EQ(resource.bytes, 16 * texels);
      }
    }
  }
  EXPECT_THAT(named(renderer.plan()), Contains("surroundings"));
}

TEST(Refraction, OtherLooksHaveNoneOfIt) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(100);
  const std::array own = {"surroundings", "rain_refraction.frag", "rain_refraction.glsl",
                          "refraction masks", "outlines of drops"};
  for (const auto look : {StreakLook::traced, StreakLook::sphere, StreakLook::white}) {
    RenderOptions options = refracting();
    options.look = look;
    RainRenderer renderer(scene, masked_atlas(), options);
    RainRenderer without(scene, sky_atlas(), {.widest_splat_px = 0, .look = look});
    for (const char* name : own) EXPECT_THAT(named(renderer.plan()), Not(Contains(name)));
    EXPECT_EQ(renderer.render(1).color.values, without.render(1).color.values);
  }
  RainRenderer renderer(scene, masked_atlas(), refracting());
  for (const char* name : own) EXPECT_THAT(named(renderer.plan()), Contains(name));
  EXPECT_THAT(named(renderer.plan()), Not(Contains("rain.frag")));
}

std::string refusal(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options) {
  try {
    RainRenderer renderer(scene, atlas, options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Refraction, WhatItCannotDoIsRefused) {
  PLUVIA_NEEDS_OPENGL();
  EXPECT_EQ(refusal(one_drop(), sky_atlas(), refracting()),
            "look refraction: no masks; expected those of `pluvia masks`");
  EXPECT_EQ(refusal(one_drop(), masked_atlas(), refracting(51)),
            "persistence_samples = 51; expected 1 .. 50");
  RenderOptions options = refracting();
  options.capture_px = 8;
  EXPECT_EQ(refusal(one_drop(), masked_atlas(), options), "capture_px = 8; expected 16 .. 4096");
  Scene scene = one_drop();
  scene.camera.depth_of_field = {.aperture_m = 0.02, .focus_m = 1};
  EXPECT_EQ(refusal(scene, masked_atlas(), refracting()),
            "look refraction: a lens out of focus; expected a pinhole");
  options = refracting();
  options.finest_level = 99;
  EXPECT_NE(refusal(one_drop(), masked_atlas(), options).find("finest_level = 99"),
            std::string::npos);
  scene = one_drop();
  scene.rain.sizes = {{.drops_per_m3 = 1}};
  scene.rain.box_min_m = {-1, 1, -1};
  scene.rain.box_max_m = {1, 3, 1};
  scene.rain.wind = {{.kind = WindKind::vortex, .strength = 1}};
  EXPECT_EQ(refusal(scene, masked_atlas(), refracting()),
            "look refraction: drops that wind moves by steps; expected an even wind");
  StreakAtlas brief = masked_atlas();
  brief.masks.durations_s.front() /= 2;
  EXPECT_EQ(refusal(one_drop(), brief, refracting()).substr(0, 36),
            "masks: 0.008333 s of a drop of 3.2 m");
  StreakAtlas few = masked_atlas();
  few.masks.oscillations.back() = 77;
  EXPECT_EQ(refusal(one_drop(), few, refracting()),
            "masks: none of oscillation 9; expected all of the atlas");
}

TEST(Refraction, MasksAreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  const RefractionMasks& masks = masked_atlas().masks;
  write_refraction_masks(folder / "masks", masks);
  const RefractionMasks read = read_refraction_masks(folder / "masks");
  EXPECT_EQ(read.exits.values, masks.exits.values);
  EXPECT_EQ(read.outlines.values, masks.outlines.values);
  EXPECT_EQ(read.diameters_um, masks.diameters_um);
  EXPECT_EQ(read.durations_s, masks.durations_s);
  EXPECT_EQ(read.view_elevations_deg, masks.view_elevations_deg);
  // A masks.exr that does not belong to its table.
  write_refraction_masks(folder / "others", masks_of({.size_px = 8, .view_elevations_deg = {0}}));
  std::filesystem::copy_file(folder / "others/masks.exr", folder / "masks/masks.exr",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(read_refraction_masks(folder / "masks"), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
