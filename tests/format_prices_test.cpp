// What fewer bits and coarser levels cost, where it is known.
#include "validate/format_prices.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/synthetic_atlas.h"
#include "validate/checks.h"

namespace pluvia {
namespace {

std::vector<float> ramp(int count, float from, float ratio) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(from * std::pow(ratio, static_cast<float>(i)));
  return values;
}

TEST(FormatPrices, AHalfFloatIsOffByAtMostHalfOfItsLastBit) {
  // 11 bits of significand: half of the last is 2^-11 of the value; below 2^-14 steps are 2^-24.
  const auto values = ramp(2000, 1e-9f, 1.016f);
  const auto halves = as_half(values);
  double largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = std::abs(static_cast<double>(halves[i]) - static_cast<double>(values[i]));
    EXPECT_LE(off, std::max(0x1p-11 * static_cast<double>(values[i]), 0x1p-25)) << values[i];
    if (values[i] > 1e-4f) largest = std::max(largest, off / static_cast<double>(values[i]));
  }
  EXPECT_GT(largest, 0x1p-12);  // it is rounded at all
  EXPECT_THROW(as_half({1e6f}), std::runtime_error);
}

TEST(FormatPrices, AByteIsOffByAtMostHalfOfAStep) {
  const auto values = ramp(500, 1e-4f, 1.02f);
  const float largest = values.back();
  const auto bytes = as_bytes(values, largest);
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    worst = std::max(worst, std::abs(static_cast<double>(bytes[i] - values[i])));
  // One rounding of the product and one of the quotient besides: 1e-6 of the largest.
  EXPECT_LE(worst, static_cast<double>(largest) * (0.5 / 255 + 1e-6));
  EXPECT_GE(worst, static_cast<double>(largest) * 0.45 / 255);
  EXPECT_EQ(bytes.back(), largest);
  EXPECT_THROW(as_bytes({1}, 0), std::runtime_error);
  EXPECT_THROW(as_bytes({-1}, 1), std::runtime_error);
  EXPECT_THROW(as_bytes({2}, 1), std::runtime_error);
}

TEST(FormatPrices, ATexelStandsForThePixelsBelowIt) {
  // 5 rows of 4 under 3 rows of 2.
  const auto fine = enlarged({1, 2, 3, 4, 5, 6}, 2, 1, 4, 5);
  EXPECT_EQ(fine, (std::vector<float>{1, 1, 2, 2, 1, 1, 2, 2, 3, 3, 4, 4, 3, 3, 4, 4, 5, 5, 6, 6}));
}

TEST(FormatPrices, CoarserLevelsLoseDetailAndNoLight) {
  const StreakAtlas atlas = synthetic_atlas(
      {.cell_width_px = 8, .levels = 3, .layers = 1, .path_rows = 120, .margin_rows = 4});
  const auto tags = format_prices(atlas, 0);
  ASSERT_EQ(tags.size(), 3u + 3u + 3u);  // of each level three, the finest is none of itself ..
  const Price& half = tags[0].price;
  EXPECT_LE(half.picture, 0x1p-11);
  EXPECT_GT(half.picture, 0x1p-14);
  // Bytes: at most half of a step of the largest in every pixel.
  EXPECT_LT(tags[1].price.picture, 0.01);
  EXPECT_GT(tags[2].price.picture, tags[1].price.picture);  // one factor for all
  const Price &second = tags[3].price, &third = tags[6].price;
  EXPECT_GT(third.picture, second.picture);
  EXPECT_GT(second.picture, 0.001);
  // Heights that are odd have a row of zeros below: their texels are spread over it.
  for (const Price* price : {&second, &third}) EXPECT_NEAR(price->sum, 1, 0.01);
}

TEST(FormatPrices, AnAtlasTooDimForHalfFloatsFailsItsCheck) {
  StreakAtlas atlas = synthetic_atlas(
      {.cell_width_px = 8, .levels = 3, .layers = 1, .path_rows = 120, .margin_rows = 4});
  Report report;
  add_format_prices(atlas, report);
  ASSERT_EQ(report.checks.size(), 1u);
  EXPECT_EQ(report.checks[0].name, "tags.half");
  EXPECT_TRUE(passes(report.checks[0]));
  for (Image& level : atlas.layers[0].point) {
    for (float& value : level.values) value *= 1e-6f;
  }
  add_format_prices(atlas, report);
  EXPECT_FALSE(passes(report.checks[1]));
  for (Image& level : atlas.layers[0].point) {
    for (float& value : level.values) value = 0;
  }
  add_format_prices(atlas, report);
  EXPECT_EQ(report.checks.size(), 2u);
  ASSERT_EQ(report.skipped.size(), 1u);
  EXPECT_NE(report.skipped[0].find("tags.half"), std::string::npos);
}

}  // namespace
}  // namespace pluvia
