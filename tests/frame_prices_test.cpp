// Prices of frames, where they are known.
#include "validate/frame_prices.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "raytrace/drop_field.h"
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

TEST(FramePrices, ADistanceIsARowInPerCent) {
  const Table table = distance_table("t", {{"a", "b", {0.25, 0.01, 1.1, 0.02}}});
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a", "b", "25.0 +- 1.0 %", "110.0 +- 2.0 %"}));
}

}  // namespace
}  // namespace pluvia
