// Single drops one by one: where they are put, how their light is added up, and what the reference
// says of spheres, whose light is known.
#include "validate/drop_by_drop.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "atlas/streak_atlas.h"
#include "raytrace/drop_field.h"
#include "raytrace/generate.h"
#include "raytrace/streak_placement.h"
#include "realtime/rain_renderer.h"
#include "tests/realtime_fixture.h"
#include "tests/reference_samples.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"
#include "validate/checks.h"
#include "validate/drop_trial.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

DropsScene two_drops() {
  return {.drops = {{20, -20, 6, 0}, {33, 7, 4, 0}}, .suns = {{{10, 150}, {30, 110}, {50, 50}}}};
}

TEST(DropByDrop, AsksForTheLightsOf2006AloneOrAmongOthers) {
  StreakAtlas atlas = synthetic_atlas({.cell_width_px = 4, .levels = 2, .path_rows = 20});
  atlas.layers.resize(10, atlas.layers.front());
  EXPECT_TRUE(can_be_judged(atlas));
  atlas.lights = light_grid(10);
  EXPECT_TRUE(can_be_judged(atlas));
  atlas.lights.pop_back();  // the light from straight above
  EXPECT_FALSE(can_be_judged(atlas));
}

TEST(DropByDrop, DropsAreSeenAndLitFromTheAnglesAskedFor) {
  const StreakAtlas atlas = made_up_atlas(1);
  const DropsScene wanted = two_drops();
  const Scene scene = scene_of(wanted, atlas);
  const auto drops = drop_field(scene, make_rain_space(scene), 1, 0);
  const StreakGeometry geometry = {.pixel_m = atlas.pixel_m,
                                   .cell_width_px = 16,
                                   .exposure_s = atlas.exposure_s,
                                   .path_top_row = atlas.views[0].path_top_row};
  ASSERT_EQ(drops.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto placed = place_streak(scene, drops[i], geometry);
    ASSERT_TRUE(placed);
    EXPECT_NEAR(placed->view_elevation_deg, wanted.drops[i].view_elevation_deg, 1e-9);
    EXPECT_NEAR(placed->distance_m, wanted.drops[i].distance_m, 1e-12);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(placed->lights[k].light_elevation_deg, wanted.suns[k].elevation_deg, 1e-9);
      EXPECT_NEAR(placed->lights[k].light_azimuth_deg,
                  wanted.suns[k].azimuth_deg + wanted.drops[i].bearing_deg, 1e-9);
      EXPECT_EQ(placed->lights[k].irradiance_lux,
                100 * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)));
    }
  }
}

TEST(DropByDrop, LightIsAddedUpByStreakAndSun) {
  Image picture = make_image(8, 4, 3);
  picture.at(2, 1, 0) = 1;
  picture.at(3, 2, 0) = 2;
  picture.at(3, 2, 2) = 5;
  picture.at(6, 2, 1) = 7;  // in no rectangle
  const StreakMask mask = {
      .x0 = 2, .y0 = 1, .width = 2, .height = 2, .touched = std::vector<bool>(4, true)};
  const DropLight light = light_in(picture, {mask});
  ASSERT_EQ(light.size(), 1u);
  EXPECT_EQ(light[0], (std::array<double, 3>{3, 0, 5}));
}

TEST(DropByDrop, StreaksThatMeetOrLeaveThePictureAreRefused) {
  const StreakAtlas atlas = made_up_atlas(1);
  DropsScene drops = two_drops();
  EXPECT_EQ(rectangles_of(scene_of(drops, atlas), atlas).size(), 2u);
  drops.drops[1] = drops.drops[0];
  EXPECT_THROW(rectangles_of(scene_of(drops, atlas), atlas), std::runtime_error);
  drops.drops[1].bearing_deg = 45;
  EXPECT_THROW(rectangles_of(scene_of(drops, atlas), atlas), std::runtime_error);
}

TEST(DropByDrop, ASphereBringsTheSkyThatItHidesAndTheOrdersOfADatabaseAlmost) {
  // Under a uniform sky of 1, a drop brings as much light as it covers: pi r^2 f^2 / d^2 px^2, the
  // outline of a sphere off the axis larger by 1 / cos^3. Seen over the fall and from so near,
  // that holds to (path / distance)^2 < 2e-3. Orders 0 to 3 are 0.99682 of it.
  const StreakAtlas atlas = made_up_atlas(1);
  const DropsScene drops = {.drops = {{20, 0, 4, 0}}, .uniform_sky_cd_m2 = {1, 2, 3}};
  const Scene scene = scene_of(drops, atlas);
  const auto masks = rectangles_of(scene, atlas);
  const ReferenceSettings settings = {.error = 1e-9,
                                      .learning_passes = 2,
                                      .least_passes = 16,
                                      .most_passes = 16,
                                      .surface_samples = 1,
                                      .samples_per_px = 4000};
  ReferenceOptions options = {.cone_half_angle_rad = 5 * pi / 180};
  const double px2 = pi * std::pow(1.6e-3 * camera_frame(scene.camera).focal_px / 4, 2);
  const auto all = reference_light(scene, gn2006_preset(), {0}, masks, options, settings);
  options.most_order = 3;
  const auto cut = reference_light(scene, gn2006_preset(), {0}, masks, options, settings);
  for (std::size_t c = 0; c < 3; ++c) {
    const double sky = static_cast<double>(c) + 1;
    EXPECT_NEAR(all.light[0][c], sky * px2, 3 * all.standard_error[0][c] + 2e-3 * sky * px2);
    const double error = std::hypot(all.standard_error[0][c], cut.standard_error[0][c]);
    EXPECT_NEAR(cut.light[0][c], 0.99682 * all.light[0][c], 3 * error);
    EXPECT_LT(error, 5e-4 * all.light[0][c]) << "too blunt";
  }
}

TEST(DropByDrop, ASphereInRealTimeHasTheLightOfTheReference) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  preset.oscillations = {0};
  preset.view_elevations_deg = {20};
  preset.width_px = 8;
  preset.transfer_degree = -1;
  generate_database(preset, folder / "database");
  const StreakAtlas atlas = pack_database(folder / "database");
  const DropsScene drops = {.drops = {{20, -20, 6, 0}, {20, 0, 6, 0}},
                            .suns = {{{10, 150}, {30, 110}, {50, 50}}}};
  const Scene scene = scene_of(drops, atlas);
  const auto masks = rectangles_of(scene, atlas);
  const auto truth = reference_light(scene, preset, {0}, masks,
                                     {.cone_half_angle_rad = 5 * pi / 180, .most_order = 3},
                                     {.error = 1e-9,
                                      .learning_passes = 4,
                                      .least_passes = 12,
                                      .most_passes = 12,
                                      .surface_samples = 1,
                                      .samples_per_px = 8000});
  RainRenderer renderer(scene, atlas);
  const DropLight ours = light_in(renderer.render(0).rain, masks);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      // 2 %: of the preview's field and of light that falls in from 6 m, not from infinity.
      EXPECT_NEAR(ours[i][c], truth.light[i][c],
                  3 * truth.standard_error[i][c] + 0.02 * truth.light[i][c])
          << "drop " << i << ", sun " << c << ", standard error " << truth.standard_error[i][c];
    }
  }
}

TEST(DropByDrop, AnAtlasWithoutTheViewsIsSaidToBeSkipped) {
  const TemporaryFolder folder;
  write_atlas(folder / "atlas", made_up_atlas(1));
  Report report;
  add_reference_checks(gn2006_preset(), read_atlas(folder / "atlas"), {}, report);
  EXPECT_TRUE(report.checks.empty());
  ASSERT_EQ(report.skipped.size(), 1u);
  EXPECT_NE(report.skipped[0].find("the views 0, 20 and 40"), std::string::npos);
}

}  // namespace
}  // namespace pluvia
