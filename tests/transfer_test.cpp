#include "atlas/transfer.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

// Two pixels, two bands, four transfer pictures: picture k holds k + 1 in band a and 10 (k + 1) in
// b, its second pixel the negative of that; standard deviations 0.5 and 1.
Shard four_pictures() {
  Shard shard = {.width_px = 2, .height_px = 1, .bands = {"a", "b"}};
  for (int k = 1; k <= 4; ++k) {
    const float v = static_cast<float>(k);
    shard.transfer.push_back({.mean = {v, -v, 10 * v, -10 * v}, .variance = {0.25f, 0.25f, 1, 1}});
  }
  return shard;
}

TEST(Transfer, LitStreakIsTheDotProductInEveryBand) {
  const StreakImage lit = lit_by_environment(four_pictures(), {{1, 0, -1, 2}, {0, 0.5, 0, 0}});
  // 1 - 3 + 8 = 6; 0.5 x 20 = 10.
  EXPECT_EQ(lit.mean, (std::vector<float>{6, -6, 10, -10}));
  // ((1 + 1 + 2) 0.5)^2 = 4; (0.5 x 1)^2 = 0.25.
  EXPECT_EQ(lit.variance, (std::vector<float>{4, 4, 0.25f, 0.25f}));
}

TEST(Transfer, FewerCoefficientsAreALowerDegree) {
  const StreakImage lit = lit_by_environment(four_pictures(), {{2}, {3}});
  EXPECT_EQ(lit.mean, (std::vector<float>{2, -2, 30, -30}));
}

TEST(Transfer, OtherNumbersOfCoefficientsAreRefused) {
  const Shard shard = four_pictures();
  EXPECT_THROW(lit_by_environment(shard, {{1}}), std::invalid_argument);
  EXPECT_THROW(lit_by_environment(shard, {{1}, {}}), std::invalid_argument);
  EXPECT_THROW(lit_by_environment(shard, {{1}, {1, 2, 3, 4, 5}}), std::invalid_argument);
  Shard none = shard;
  none.transfer.clear();
  EXPECT_THROW(lit_by_environment(none, {{1}, {1}}), std::invalid_argument);
}

}  // namespace
}  // namespace pluvia
