#include "raytrace/scene_subset.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atlas_lookup.h"
#include "raytrace/drop_field.h"
#include "raytrace/streak_placement.h"
#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

Preset full_preset(bool physical) {
  const TemporaryFolder folder;
  Preset preset =
      read_preset(physical ? write_physical(folder.path()) : write_preset(folder.path()));
  preset.view_elevations_deg = {0, 20, 40, 60, 80};
  if (physical) preset.view_elevations_deg = {-80, -60, -40, -20, 0, 20, 40, 60, 80};
  preset.width_px = 32;
  return preset;
}

// One lamp ahead and one beside a small box of rain in front of the camera.
Scene small_scene(bool physical) {
  Scene scene;
  scene.camera.exposure_s = physical ? 0.004 : 1.0 / 60;
  scene.lights = {{"ahead", {0.5, 6, 3}, {1, 1, 1}}, {"right", {4, 2, 1}, {1, 1, 1}}};
  scene.rain.sizes = {{.r0_m = physical ? 1.5e-3 : 1.6e-3, .drops_per_m3 = 800}};
  scene.rain.box_min_m = {-1, 0, 0.5};
  scene.rain.box_max_m = {1, 3, 3};
  return scene;
}

StreakAtlas tables(const Preset& preset, int diameter_um) {
  StreakAtlas atlas;
  const SizeRecord size = size_of(preset, diameter_um);
  atlas.cell_width_px = preset.width_px;
  atlas.exposure_s = size.span_s;
  atlas.pixel_m = size.pixel_m;
  atlas.lights = preset.lights;
  for (const int view : preset.view_elevations_deg) {
    const StreakFrame frame = shard_frame(preset, {diameter_um, 0, view});
    atlas.views.push_back({.elevation_deg = view,
                           .height_px = frame.height_px,
                           .path_top_row = frame.path_top_row,
                           .path_bottom_row = frame.path_top_row + frame.path_rows});
  }
  return atlas;
}

// Whether the streak's parallelogram and the picture have a point in common: no edge of either
// separates them.
bool is_in_picture(const StreakPlacement& placed, const Camera& camera, double cell_width,
                   double rows) {
  const Eigen::Vector2d across = cell_width * placed.column_px, along = rows * placed.row_px;
  const Eigen::Vector2d corners[] = {placed.origin_px, placed.origin_px + across,
                                     placed.origin_px + along, placed.origin_px + across + along};
  const Eigen::Vector2d picture[] = {
      {0, 0}, {camera.width_px, 0}, {0, camera.height_px}, {camera.width_px, camera.height_px}};
  const Eigen::Vector2d axes[] = {
      {1, 0}, {0, 1}, {-across.y(), across.x()}, {-along.y(), along.x()}};
  return std::none_of(std::begin(axes), std::end(axes), [&](const Eigen::Vector2d& axis) {
    double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
    for (int i = 0; i < 4; ++i) {
      const double values[] = {axis.dot(corners[i]), axis.dot(picture[i])};
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], values[k]);
        high[k] = std::max(high[k], values[k]);
      }
    }
    return high[0] < low[1] || high[1] < low[0];
  });
}

struct Lookup {
  int view_deg[2];
  double weight[2];
  LightDirection light;
};

Lookup lookup(const StreakAtlas& atlas, const StreakPlacement& placed, const LitStreak& lit,
              ViewsBelow below) {
  const CellChoice choice =
      choose_cells(atlas, fold_angles(placed.view_elevation_deg, lit.light_elevation_deg,
                                      lit.light_azimuth_deg, 0, below));
  const auto elevation = [&](int i) {
    return atlas.views[static_cast<std::size_t>(choice.view[i])].elevation_deg;
  };
  return {{elevation(0), elevation(1)},
          {choice.view_weight[0], choice.view_weight[1]},
          atlas.lights[static_cast<std::size_t>(choice.light)]};
}

// The subset's tables answer as the full ones for every drop in the picture. Returns how many drops
// were.
int expect_sufficient(const Preset& preset, const Scene& scene, const Preset& kept) {
  const int um = static_cast<int>(std::lround(2e6 * scene.rain.sizes[0].r0_m));
  const StreakAtlas full = tables(preset, um), subset = tables(kept, um);
  const StreakGeometry geometry = {.pixel_m = full.pixel_m,
                                   .cell_width_px = static_cast<double>(full.cell_width_px),
                                   .exposure_s = full.exposure_s,
                                   .path_top_row = full.views[0].path_top_row,
                                   .mean_radius_m = scene.rain.sizes[0].r0_m};
  const AtlasView& last = full.views.back();
  const double beyond = full.views[0].path_top_row + last.height_px - last.path_bottom_row;
  int seen = 0;
  for (const double time_s : {0.0, 0.137, 3.3}) {
    for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, time_s)) {
      const auto placed = place_streak(scene, drop, geometry);
      if (!placed || !is_in_picture(*placed, scene.camera, geometry.cell_width_px,
                                    placed->path_rows + beyond)) {
        continue;
      }
      ++seen;
      for (const LitStreak& lit : placed->lights) {
        const Lookup wanted = lookup(full, *placed, lit, views_below(full));
        const Lookup found = lookup(subset, *placed, lit, views_below(subset));
        EXPECT_EQ(light_name(found.light), light_name(wanted.light)) << "drop " << drop.id;
        EXPECT_NEAR(found.weight[0] * found.view_deg[0] + found.weight[1] * found.view_deg[1],
                    wanted.weight[0] * wanted.view_deg[0] + wanted.weight[1] * wanted.view_deg[1],
                    1e-9);
        EXPECT_TRUE(wanted.weight[1] == 0 || found.view_deg[1] == wanted.view_deg[1]);
        EXPECT_EQ(found.view_deg[0], wanted.view_deg[0]) << placed->view_elevation_deg;
        if (testing::Test::HasFailure()) return seen;
      }
    }
  }
  return seen;
}

struct Look {
  const char* name;
  Eigen::Vector3d position_m, target_m;
};

const Look looks[] = {{"level", {0, 0, 1.6}, {0, 1, 1.6}},
                      {"up", {0, 0.5, 0.3}, {0, 1.2, 2}},
                      {"down", {0.2, 0.5, 4}, {0.1, 1.5, 0}},
                      {"straight down", {0, 1.5, 5}, {0, 1.5, 0}},
                      {"in the rain", {0.5, 1.5, 1.5}, {-0.5, 2.5, 1.7}}};

void expect_every_lookup_kept(bool physical) {
  const Preset preset = full_preset(physical);
  for (const Look& look : looks) {
    SCOPED_TRACE(look.name);
    Scene scene = small_scene(physical);
    scene.camera.position_m = look.position_m;
    scene.camera.target_m = look.target_m;
    const SceneSubset subset = scene_subset(preset, scene, "scene.toml");
    EXPECT_GT(expect_sufficient(preset, scene, subset.preset), 100);
    EXPECT_LE(subset.images, subset.all_images);
  }
}

TEST(SceneSubset, EveryLookupOfEveryDropInViewIsKept) {
  expect_every_lookup_kept(false);
}

TEST(SceneSubset, EveryLookupIsKeptWhereViewsFromBelowAreTheirOwn) {
  expect_every_lookup_kept(true);
}

TEST(SceneSubset, NarrowViewsKeepWhatTheirStreaksReach) {
  // Half to one and a half degrees above the horizon, a lamp far to the left, right or ahead. A
  // drop half a path (16 mm) below the picture shows its end there; seen from 1 m it is 0.4 degrees
  // below the horizon, and asks for the view +20. Lights: one to three directions at a time.
  for (const double lamp_x_m : {-300.0, -30.0, 0.0, 30.0, 300.0}) {
    SCOPED_TRACE(lamp_x_m);
    const Preset preset = full_preset(true);
    Scene scene = small_scene(true);
    scene.camera = {.position_m = {0, 0, 1.6},
                    .target_m = {0, 1, 1.6 + std::tan(3.14159265 / 180)},
                    .vertical_fov_deg = 1,
                    .exposure_s = 0.004};
    scene.lights = {{"far", {lamp_x_m, 60, 7}, {1, 1, 1}}};
    scene.rain.sizes[0].drops_per_m3 = 40000;
    scene.rain.box_min_m = {-0.2, 0.5, 1.4};
    scene.rain.box_max_m = {0.2, 2, 1.8};
    const SceneSubset subset = scene_subset(preset, scene, "scene.toml");
    EXPECT_GT(expect_sufficient(preset, scene, subset.preset), 100);
    EXPECT_THAT(subset.preset.view_elevations_deg, testing::ElementsAre(-20, 0, 20));
    EXPECT_LE(subset.preset.lights.size(), 4u);
  }
}

TEST(SceneSubset, WhatIsFarFromEveryLookupIsLeftOut) {
  // A level view of 10 degrees, lamps behind and at the side: no steep view, and few lights.
  Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.camera.vertical_fov_deg = 10;
  scene.rain.box_min_m.y() = 2;
  const SceneSubset subset = scene_subset(preset, scene, "scene.toml");
  EXPECT_THAT(subset.preset.view_elevations_deg, testing::ElementsAre(0, 20));
  EXPECT_LT(subset.preset.lights.size(), 15u);
  EXPECT_GE(subset.preset.lights.size(), 2u);
  EXPECT_EQ(subset.preset.oscillations, preset.oscillations);
  EXPECT_EQ(subset.shards, 2 * 2);
  EXPECT_EQ(subset.all_images, 10 * (74 + 1 + 1));
  EXPECT_FALSE(subset.preset.environment) << "no environment shines";
  scene.environment.uniform_cd_m2 = {0, 0, 1};
  EXPECT_TRUE(scene_subset(preset, scene, "scene.toml").preset.environment);
  // Harmonics only where a map shines, and none were asked for so far.
  preset.transfer_degree = 3;
  const SceneSubset uniform = scene_subset(preset, scene, "scene.toml");
  EXPECT_EQ(uniform.preset.transfer_degree, -1);
  EXPECT_EQ(uniform.all_images, 10 * (74 + 1 + 16 + 1));
  EXPECT_EQ(uniform.rows.back().what, "transfer");
  EXPECT_EQ(uniform.rows.back().left_out, "degree 3");
  scene.environment.map_file = "sky.exr";
  const SceneSubset mapped = scene_subset(preset, scene, "scene.toml");
  EXPECT_EQ(mapped.preset.transfer_degree, 3);
  EXPECT_EQ(mapped.images - uniform.images, 16 * mapped.shards);
  scene.environment.scale_cd_m2 = 0;
  EXPECT_EQ(scene_subset(preset, scene, "scene.toml").preset.transfer_degree, -1);
}

TEST(SceneSubset, ADropStraightBetweenCameraAndLampNeedsTheLightBehindIt) {
  // Lamp at azimuth 180, elevation 0: half-way between v -10 and v +10 at h 170, both in reach.
  const Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.camera = {.position_m = {0, 0, 1.5}, .target_m = {0, 1, 1.5}, .vertical_fov_deg = 1};
  scene.lights = {{"behind", {0, 100, 1.5}, {1, 1, 1}}};
  scene.rain.box_min_m = {-1, 9, 1};
  scene.rain.box_max_m = {1, 10, 2};
  const auto lights = scene_subset(preset, scene, "s").preset.lights;
  EXPECT_THAT(lights, testing::ElementsAre(LightDirection{-10, 170}, LightDirection{10, 170}));
}

TEST(SceneSubset, FinerGridsOfLightsArePickedFromToo) {
  const Scene scene = small_scene(false);
  for (const int step_deg : {10, 5}) {
    Preset preset = full_preset(false);
    preset.lights = light_grid(step_deg);
    const SceneSubset subset = scene_subset(preset, scene, "s");
    EXPECT_GT(expect_sufficient(preset, scene, subset.preset), 100) << step_deg;
    EXPECT_LT(subset.preset.lights.size(), preset.lights.size() / 2) << step_deg;
  }
}

TEST(SceneSubset, SizesAndBandsAreThoseOfTheScene) {
  Preset preset = full_preset(true);
  preset.physical->bands = rgb_bands();
  Scene scene = small_scene(true);
  for (Light& light : scene.lights) light.intensity_cd = {1, 0.5, 0};
  EXPECT_THAT(diameters_of(scene_subset(preset, scene, "s").preset), testing::ElementsAre(3000));
  const auto bands = bands_of(scene_subset(preset, scene, "s").preset);
  ASSERT_EQ(bands.size(), 2u);
  EXPECT_EQ(bands[0].name + bands[1].name, "GR");
  scene.rain.sizes[0].r0_m = 1e-3;  // between 0.5 and 3 mm
  EXPECT_THAT(diameters_of(scene_subset(preset, scene, "s").preset),
              testing::ElementsAre(500, 3000));
  for (Light& light : scene.lights) light.intensity_cd = {0, 0, 0};
  EXPECT_EQ(bands_of(scene_subset(preset, scene, "s").preset).size(), 3u) << "a dark scene";
}

TEST(SceneSubset, ACameraFarAboveItsRainAsksForViewsFromAbove) {
  const Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.camera.position_m = {0, 0, 60};
  scene.camera.target_m = {0, 0.5, 3};
  scene.rain.box_min_m = {-2, -2, 0};
  scene.rain.box_max_m = {2, 2, 3};
  const SceneSubset subset = scene_subset(preset, scene, "s");
  EXPECT_THAT(subset.preset.view_elevations_deg, testing::Contains(80));
  EXPECT_GT(expect_sufficient(preset, scene, subset.preset), 1000);
}

TEST(SceneSubset, SlantedRainOfTwoSizesHasTablesForAll) {
  const Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.rain.sizes[0].velocity_m_s = {3, 2, -7};
  EXPECT_GT(expect_sufficient(preset, scene, scene_subset(preset, scene, "s").preset), 100);
}

TEST(SceneSubset, DropsInAWhirlGoAnyWayAndNeedEveryViewAndLight) {
  const Preset preset = full_preset(true);
  Scene scene = small_scene(true);
  const auto kept_views = [&] {
    return scene_subset(preset, scene, "scene.toml").preset.view_elevations_deg;
  };
  EXPECT_LT(kept_views().size(), preset.view_elevations_deg.size());
  scene.rain.wind = {{.kind = WindKind::vortex, .strength = 5}};
  EXPECT_EQ(kept_views(), preset.view_elevations_deg);
  EXPECT_EQ(scene_subset(preset, scene, "scene.toml").preset.lights.size(), preset.lights.size());
}

TEST(SceneSubset, WithoutALampOneLightIsKept) {
  const Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.lights.clear();
  EXPECT_EQ(scene_subset(preset, scene, "s").preset.lights.size(), 1u);
}

TEST(SceneSubset, ALampAmongTheDropsInViewShinesFromEverywhere) {
  const Preset preset = full_preset(false);
  Scene scene = small_scene(false);
  scene.lights = {{"among", {0, 2, 1.6}, {1, 1, 1}}};
  EXPECT_EQ(scene_subset(preset, scene, "s").preset.lights.size(), 74u);
}

TEST(SceneSubset, ScenesThatAskForNothingOrForMoreAreRefused) {
  const Preset preset = full_preset(false);
  const auto refusal = [&](auto change) {
    Scene scene = small_scene(false);
    change(scene);
    return message_of([&] { scene_subset(preset, scene, "s.toml"); });
  };
  EXPECT_EQ(refusal([](Scene& s) { s.rain.sizes.clear(); }),
            "s.toml: no rain; expected [rain] with drops, or a [[drop]]");
  EXPECT_THAT(
      refusal([](Scene& s) {
        s.camera.target_m = {0, -1, 1.6};
      }),
      HasSubstr("s.toml: no drop of the rain can be seen; expected rain in the camera's view"));
}

}  // namespace
}  // namespace pluvia
