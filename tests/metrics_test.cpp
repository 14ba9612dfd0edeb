#include "validate/metrics.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

TEST(RelativeRmse, IsTheDistanceInUnitsOfTheReference) {
  const Image a{2, 1, 2, {1, 2, 3, 4}}, b{2, 1, 2, {1, 0, 0, 2}};
  // Differences 0, 2, 3, 2: 17; reference 1 + 4 = 5. By the other: 17 / 30.
  EXPECT_DOUBLE_EQ(relative_rmse(a, b), std::sqrt(17.0 / 5.0));
  EXPECT_DOUBLE_EQ(relative_rmse(b, a), std::sqrt(17.0 / 30.0));
}

TEST(RelativeRmse, OfAScaledPictureIsTheScaleLessOne) {
  Image a = make_image(50, 40, 3), b = a;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    b.values[i] = std::ldexp(static_cast<float>(i % 7), 80);  // squares beyond float
    a.values[i] = 1.25f * b.values[i];                        // exact in binary
  }
  EXPECT_NEAR(relative_rmse(a, b), 0.25, 1e-12);
}

TEST(RelativeRmse, OfTwoBlackPicturesIsZero) {
  EXPECT_EQ(relative_rmse(make_image(3, 2), make_image(3, 2)), 0);
}

TEST(RelativeRmse, RefusesWhatHasNoAnswer) {
  Image white = make_image(3, 2);
  white.values.assign(6, 1.0f);
  EXPECT_THROW(relative_rmse(white, make_image(3, 2)), std::runtime_error);
  EXPECT_THROW(relative_rmse(white, make_image(2, 3)), std::runtime_error);
  EXPECT_THROW(relative_rmse({}, {}), std::runtime_error);
  for (const float broken :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Image bad = white;
    bad.at(1, 1) = broken;
    EXPECT_THROW(relative_rmse(bad, white), std::runtime_error);
    EXPECT_THROW(relative_rmse(white, bad), std::runtime_error);
  }
}

}  // namespace
}  // namespace pluvia
