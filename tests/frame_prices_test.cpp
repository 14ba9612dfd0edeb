// Prices of frames, where they are known.
#include "validate/frame_prices.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
#include "raytrace/preset.h"
#include "raytrace/streak_geometry.h"
#include "raytrace/streak_placement.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

Image ramp(int width, int height) {
  Image image = make_image(width, height, 3);
  std::iota(image.values.begin(), image.values.end(), 1.0f);
  return image;
}

TEST(FramePrices, SquaresHoldEveryPixelOnce) {
  const Image truth = ramp(50, 33);
  Image ours = truth;
  ours.at(49, 32, 2) += 7;  // in the corner's smaller square
  const auto sums = square_sums(ours, truth, 20);
  ASSERT_EQ(sums.size(), 3u * 2);
  double light = 0, squares = 0;
  for (const StreakSums& sum : sums) {
    light += sum.truth_light;
    squares += sum.squares;
  }
  const double count = 50 * 33 * 3;
  EXPECT_DOUBLE_EQ(light, count * (count + 1) / 2);
  EXPECT_DOUBLE_EQ(squares, 49);
  EXPECT_DOUBLE_EQ(sums.back().squares, 49);
}

TEST(FramePrices, RainThatIsTooBrightIsAsFarOffWithoutItsNoise) {
  // Known variance, no noise drawn: what is subtracted is sum v of sum d^2, and of sum t^2.
  ReferenceFrame truth = {.rain = ramp(20, 20), .variance = make_image(20, 20, 3)};
  Image bright = truth.rain;
  for (float& value : bright.values) value *= 1.25f;
  Distance distance = frame_distance(bright, truth);
  EXPECT_NEAR(distance.relative_rmse, 0.25, 1e-6);
  EXPECT_NEAR(distance.sum, 1.25, 1e-6);
  EXPECT_EQ(distance.sum_error, 0);
  for (float& value : truth.variance.values) value = 4;
  distance = frame_distance(bright, truth);
  const double n = 1200, squares = n * (n + 1) * (2 * n + 1) / 6;
  EXPECT_NEAR(distance.relative_rmse, std::sqrt((squares / 16 - 4 * n) / (squares - 4 * n)), 1e-6);
  EXPECT_NEAR(distance.sum_error, std::sqrt(4 * n) / (n * (n + 1) / 2), 1e-9);
}

TEST(FramePrices, TheSmallFrameHasSomeHundredNearDrops) {
  StreakAtlas atlas = quarter_atlas();
  const Scene scene = small_frame(atlas, "data");
  const auto drops = drop_field(scene, make_rain_space(scene), 10, 0);
  EXPECT_GT(drops.size(), 200u);
  EXPECT_LT(drops.size(), 800u);
  for (const Drop& drop : drops) EXPECT_GT(drop.centre_m.y(), 0.9);
}

bool in_view(const StreakPlacement& placed, const Camera& camera) {
  const Eigen::Vector2d begin = placed.origin_px;
  const Eigen::Vector2d end = begin + placed.path_rows * placed.row_px;
  return begin.x() > 0 && begin.x() < camera.width_px && end.y() > 0 &&
         begin.y() < camera.height_px;
}

TEST(FramePrices, NearDropsHaveWideStreaks) {
  const StreakAtlas atlas = made_up_atlas(10);
  const auto geometry = streak_geometry(atlas);
  for (const Scene& scene : {near_frame(atlas, "data"), near_night_frame(atlas, "data")}) {
    std::vector<double> widths_px;
    for (const Drop& drop : drop_field(scene, make_rain_space(scene), 10, 0)) {
      const auto placed = place_streak(scene, drop, geometry);
      if (placed && in_view(*placed, scene.camera))
        widths_px.push_back(2 * atlas.mean_radius_m / atlas.pixel_m * placed->column_px.norm());
    }
    // f = 135 px / (2 tan 4.5 degrees) = 858 px, drops 3.2 mm wide, 0.15 to 0.6 m away.
    ASSERT_GE(widths_px.size(), 4u);
    EXPECT_LE(widths_px.size(), 30u);
    const auto [least, most] = std::minmax_element(widths_px.begin(), widths_px.end());
    EXPECT_GT(*least, 4.5);
    EXPECT_LT(*most, 18.4);
    EXPECT_GT(*most, 10);
  }
}

TEST(FramePrices, TheMeanOfTwoReferencesHasHalfTheirVariance) {
  ReferenceFrame one = {ramp(4, 3), make_image(4, 3, 3), make_image(4, 3, 1)}, other = one;
  for (float& value : one.variance.values) value = 8;
  for (float& value : other.variance.values) value = 4;
  for (float& value : other.rain.values) value += 2;
  for (float& value : other.coverage.values) value = 0.5F;
  const ReferenceFrame mean = mean_of(one, other);
  EXPECT_EQ(mean.rain.at(3, 2, 1), one.rain.at(3, 2, 1) + 1);
  EXPECT_EQ(mean.variance.at(1, 1, 0), 3);
  EXPECT_EQ(mean.coverage.at(2, 0), 0.25F);
  // Of the values 2 .. 37, each with a variance of 3.
  const double n = 36, squares = (n + 1) * (n + 2) * (2 * n + 3) / 6 - 1;
  EXPECT_NEAR(noise_of(mean), std::sqrt(3 * n / (squares - 3 * n)), 1e-6);
}

TEST(FramePrices, ReferencesOfNearLampsHaveNoNoiseInCommon) {
  // From lamps 10 km away light comes from one direction and is as bright all along the path (to
  // 2e-5), so both sides are the same streaks: what they differ by is noise. Over the stated noise
  // the squares of 6 streaks add up to a chi-square of 6, heavier in its tail since 12 passes tell
  // their own spread to 20 %: below 0.2 for 1 seed in 6,000, above 30 for 1 in 1,800. With one seed
  // on both sides it is 2e-10.
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  const auto fluxes = near_lamp_fluxes(quarter_atlas(), preset, {1e4}, 300);
  ASSERT_EQ(fluxes.size(), 1u);
  ASSERT_EQ(fluxes[0].size(), 6u);
  double chi_square = 0;
  for (const StreakFlux& flux : fluxes[0])
    chi_square += std::pow((flux.measured - flux.truth) / flux.standard_error, 2);
  EXPECT_GT(chi_square, 0.2);
  EXPECT_LT(chi_square, 30);
}

TEST(FramePrices, ADistanceIsARowInPerCent) {
  const Table table = distance_table("t", {{"a", "b", {0.25, 0.01, 1.1, 0.02}}});
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a", "b", "25.0 +- 1.0 %", "110.0 +- 2.0 %"}));
}

}  // namespace
}  // namespace pluvia
