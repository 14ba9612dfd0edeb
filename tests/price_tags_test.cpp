// Prices of approximations: of streaks whose errors are known by construction.
#include "validate/price_tags.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

constexpr double rounding = 1e-7;  // of floats

TEST(PriceTags, LightThatIsTooBrightCostsWhatItIsTooBright) {
  // a = 1.1 t: every error is 0.1, and no choice of streaks changes it.
  const std::vector<std::vector<float>> truths = {{1, 2, 3}, {4, 0, 1}, {0, 5, 0}};
  std::vector<StreakSums> sums;
  for (const auto& truth : truths) {
    std::vector<float> ours = truth;
    for (float& value : ours) value *= 1.1f;
    sums.push_back(streak_sums(ours, truth));
  }
  const Price price = price_of(sums);
  EXPECT_NEAR(price.picture, 0.1, rounding);
  EXPECT_NEAR(price.light, 0.1, rounding);
  EXPECT_NEAR(price.sum, 1.1, rounding);
  EXPECT_NEAR(price.picture_error, 0, rounding);
  EXPECT_NEAR(price.light_error, 0, rounding);
  EXPECT_NEAR(price.sum_error, 0, rounding);
}

TEST(PriceTags, LightThatMovesWithinAStreakCostsPicturesAlone) {
  const StreakSums moved = streak_sums({0, 1}, {1, 0});
  const Price price = price_of({moved, moved});
  EXPECT_DOUBLE_EQ(price.picture, std::sqrt(2));
  EXPECT_EQ(price.light, 0);
  EXPECT_EQ(price.sum, 1);
}

TEST(PriceTags, TheStandardErrorIsThatOfTheMean) {
  // Truths of 1: the sum is the mean of the lights, and its jackknife error is exactly the usual
  // standard error of a mean, s / sqrt(n): of 1, 2, 3, 6 (mean 3, squares 14) sqrt(14 / 3 / 4).
  std::vector<StreakSums> sums;
  for (const float light : {1.0f, 2.0f, 3.0f, 6.0f}) sums.push_back(streak_sums({light}, {1}));
  const Price price = price_of(sums);
  EXPECT_DOUBLE_EQ(price.sum, 3);
  EXPECT_NEAR(price.sum_error, std::sqrt(14.0 / 12), 1e-12);
}

TEST(PriceTags, TheMedianIsOfEachStreaksOwnLight) {
  // Off by 10, 20 and 300 %, the last one bright; one is dark.
  const Price price = price_of({streak_sums({1.1f}, {1}), streak_sums({0.8f}, {1}),
                                streak_sums({400}, {100}), streak_sums({0}, {0})});
  EXPECT_NEAR(price.typical, 0.2, rounding);
}

TEST(PriceTags, WhatCannotBePricedIsRefused) {
  EXPECT_THROW(streak_sums({1, 2}, {1}), std::invalid_argument);
  EXPECT_THROW(streak_sums({std::numeric_limits<float>::quiet_NaN()}, {1}), std::runtime_error);
  EXPECT_THROW(price_of({streak_sums({1}, {1})}), std::invalid_argument);
  EXPECT_THROW(price_of({streak_sums({1}, {1}), streak_sums({1}, {0})}), std::runtime_error);
}

TEST(PriceTags, TwoDigitsOfTheErrorAreShownOfAtMostFourDecimals) {
  EXPECT_EQ(percent_text(0.3921, 0.0114), "39.2 +- 1.1 %");
  EXPECT_EQ(percent_text(0.000312, 0.0000021), "0.0312 +- 0.0002 %");
  EXPECT_EQ(percent_text(1.2, 0.25), "120 +- 25 %");
}

TEST(PriceTags, ATableHasARowForEachTag) {
  const Table table = price_table("t", {{"a", "b", {0.1, 0.01, 0.2, 0.01, 0.9, 0.01, 0.05}, "c"}});
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a", "b", "10.0 +- 1.0 %", "20.0 +- 1.0 %",
                                                     "5 %", "90.0 +- 1.0 %", "c"}));
  EXPECT_EQ(table.head.size(), table.rows[0].size());
}

}  // namespace
}  // namespace pluvia
