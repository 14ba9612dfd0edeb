// The light of single drops without a renderer: traced, and looked up.
#include "validate/direct_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/sphere_closed_form.h"
#include "raytrace/streak_geometry.h"
#include "tests/synthetic_atlas.h"
#include "validate/drop_trial.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

Scene three_drops(const StreakAtlas& atlas) {
  return scene_of({.drops = {{13, -17, 5, 0}, {27, 3, 4, 1}, {38, 21, 6, 2}},
                   .suns = {{{13, 140}, {40, 103}, {67, 61}}}},
                  atlas);
}

TEST(DirectLight, CellsAddUpToTheExactCompositesLight) {
  const StreakAtlas atlas = made_up_atlas(10);
  const Scene scene = three_drops(atlas);
  const auto masks = rectangles_of(scene, atlas);
  Image far = make_image(256, 256, 1);
  std::fill(far.values.begin(), far.values.end(), std::numeric_limits<float>::infinity());
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  for (const LookupMode mode :
       {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear}) {
    const DropLight cells = looked_up_light(scene, atlas, mode);
    const DropLight pixels = light_in(composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
                                                      make_image(256, 256, 3), far, mode)
                                          .rain,
                                      masks);
    ASSERT_EQ(cells.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      // Pixels are floats; the composite cuts texels where the stretch of rows changes.
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(cells[i][c], pixels[i][c], 1e-4 * pixels[i][c]) << i << " " << c;
    }
  }
}

TEST(DirectLight, ASphereHasTheLightOfTheClosedForm) {
  // Set 0 is rigid: in every direction pi r0^2 times the closed form's intensity, per lux. The
  // texel is pixel_m^2, so r0^2 is (r0 / pixel_m)^2 of them. Fields of level 2 keep it to 1 %.
  const StreakAtlas atlas = made_up_atlas(10);
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  const Scene scene =
      scene_of({.drops = {{20, 0, 5, 0}}, .suns = {{{13, 140}, {40, 103}, {67, 61}}}}, atlas);
  const DropLight light = direct_light(scene, atlas, preset, 2);
  const auto placed = place_streak(scene, drop_field(scene, make_rain_space(scene), 10, 0).at(0),
                                   streak_geometry(atlas));
  const double texel_px2 = std::abs(placed->column_px.x() * placed->row_px.y() -
                                    placed->column_px.y() * placed->row_px.x());
  const double disc_px2 = pi * std::pow(1.6e-3 / atlas.pixel_m, 2) * texel_px2;
  const View view = view_from_elevation(20);
  for (std::size_t k = 0; k < 3; ++k) {
    const LitStreak& lit = placed->lights[k];
    const double angle = std::acos(
        -light_direction(lit.light_elevation_deg, lit.light_azimuth_deg).dot(view.to_camera));
    const double expected =
        100 * disc_px2 * sphere_intensity_in_cone(1.333, 3, angle, 5 * pi / 180);
    EXPECT_NEAR(light[0][k], expected, 0.01 * expected) << k;
  }
}

TEST(DirectLight, LightsThatTheTracerCannotNameAreRefused) {
  const StreakAtlas atlas = made_up_atlas(10);
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  const Scene scene =
      scene_of({.drops = {{20, 0, 5, 0}}, .suns = {{{13.3, 140}, {40, 103}, {67, 61}}}}, atlas);
  EXPECT_THROW(direct_light(scene, atlas, preset, 0), std::runtime_error);
}

TEST(DropTrial, NoiseOfSquaresComesBackFromEitherForm) {
  // Above the noise the error of a root is that of the square over twice the root; below, the root
  // of the square's error stands in its place.
  NoisyError error = {.squared = 0.16, .standard_error = 0.0016};
  const Distance above = beyond_noise(error);
  EXPECT_DOUBLE_EQ(above.relative_rmse, 0.4);
  EXPECT_DOUBLE_EQ(above.standard_error, 0.002);
  EXPECT_DOUBLE_EQ(hidden_in_noise(above), 0.04);
  error.squared = 0.001;
  const Distance below = beyond_noise(error);
  EXPECT_EQ(below.relative_rmse, 0);
  EXPECT_DOUBLE_EQ(hidden_in_noise(below), 0.04);
}

}  // namespace
}  // namespace pluvia
