#include "validate/false_alarm.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

TEST(FalseAlarm, BoundsAreTheTabulatedQuantiles) {
  // Tables of the normal and of Student's t distribution, to their last digit.
  EXPECT_NEAR(two_sided_bound(0.05, 1), 1.959964, 5e-7);
  EXPECT_NEAR(two_sided_bound(0.01, 1), 2.575829, 5e-7);
  EXPECT_NEAR(one_sided_bound(0.05, 1), 1.644854, 5e-7);
  EXPECT_NEAR(two_sided_bound(0.05, 1, 15), 2.131450, 5e-7);
  EXPECT_NEAR(two_sided_bound(0.01, 1, 15), 2.946713, 5e-7);
  // One degree of freedom is Cauchy's distribution: P(|t| > x) = 1 - 2 atan(x) / pi.
  EXPECT_NEAR(two_sided_bound(0.01, 1, 1), std::tan(0.99 * std::numbers::pi / 2), 1e-6);
}

TEST(FalseAlarm, ManyComparisonsTogetherKeepTheRate) {
  for (const int comparisons : {1, 6, 100}) {
    const double each = each_false_alarm(0.01, comparisons);
    EXPECT_NEAR(1 - std::pow(1 - each, comparisons), 0.01, 1e-13) << comparisons;
    EXPECT_LE(0.01, comparisons * each + 1e-15) << comparisons;
  }
}

TEST(FalseAlarm, FamiliesOfRightComparisonsFailAsOftenAsIsSaid) {
  // 20,000 families of six, four means over 16 replicates by their own standard errors and two
  // normal ones, at a rate of 0.1. The count is binomial: 2000 +- 42. Of this test's own seeds one
  // in 10,000 would be beyond 3.9 of those.
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const double by_replicates = two_sided_bound(0.1, 6, 15), known = two_sided_bound(0.1, 6);
  int failed = 0;
  for (int family = 0; family < 20000; ++family) {
    bool alarm = false;
    for (int k = 0; k < 4; ++k) {
      double sum = 0, squares = 0;
      for (int i = 0; i < 16; ++i) {
        const double x = normal(random);
        sum += x;
        squares += x * x;
      }
      const double mean = sum / 16, error = std::sqrt((squares / 16 - mean * mean) / 15);
      alarm = alarm || std::abs(mean) > by_replicates * error;
    }
    for (int k = 0; k < 2; ++k) alarm = alarm || std::abs(normal(random)) > known;
    failed += alarm;
  }
  EXPECT_NEAR(failed, 2000, 3.9 * std::sqrt(20000 * 0.1 * 0.9));
}

}  // namespace
}  // namespace pluvia
