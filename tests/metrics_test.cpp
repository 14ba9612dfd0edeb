#include "validate/metrics.h"

#include <cmath>
#include <limits>
#include <random>
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

// A smooth truth, a picture that is off by `shift` of it, and variances of many sizes.
struct Noisy {
  Image truth = make_image(40, 30), test = truth, variance = truth;
};

Noisy noisy_case(double shift) {
  Noisy noisy;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double t = 1 + 0.5 * std::sin(0.3 * x) * std::cos(0.2 * y);
      noisy.truth.at(x, y) = static_cast<float>(t);
      noisy.test.at(x, y) = static_cast<float>(t * (1 + shift * std::cos(0.7 * x)));
      noisy.variance.at(x, y) = static_cast<float>(0.0004 * (1 + x % 5));
    }
  }
  return noisy;
}

Image with_noise(const Noisy& noisy, std::mt19937& random) {
  Image reference = noisy.truth;
  for (std::size_t i = 0; i < reference.values.size(); ++i) {
    std::normal_distribution<double> noise(0, std::sqrt(noisy.variance.values[i]));
    reference.values[i] += static_cast<float>(noise(random));
  }
  return reference;
}

struct Draws {                                // of 400 references with their noise
  double mean = 0, scatter = 0, claimed = 0;  // of NoisyError::squared, and its standard error
  int below_noise = 0;
};
constexpr int draws = 400;

Draws draw(const Noisy& noisy) {
  std::mt19937 random(11);
  Draws result;
  double squares = 0;
  for (int i = 0; i < draws; ++i) {
    const NoisyError error = noisy_error(noisy.test, with_noise(noisy, random), noisy.variance);
    result.mean += error.squared / draws;
    squares += error.squared * error.squared / draws;
    result.claimed += error.standard_error / draws;
    result.below_noise += error.below_noise ? 1 : 0;
  }
  result.scatter = std::sqrt(squares - result.mean * result.mean);
  return result;
}

TEST(NoisyError, IsOnAverageTheErrorWithoutTheNoiseAndScattersAsItSays) {
  for (const double shift : {0.0, 0.02, 0.2}) {
    const Noisy noisy = noisy_case(shift);
    const double truth = std::pow(relative_rmse(noisy.test, noisy.truth), 2);
    const Draws result = draw(noisy);
    // The mean of 400 draws is good to a twentieth of their scatter: five of its standard errors.
    EXPECT_NEAR(result.mean, truth, 0.25 * result.scatter) << shift;
    // The scatter of 400 draws is good to 1 / sqrt(800) of itself: five times that.
    EXPECT_NEAR(result.claimed / result.scatter, 1, 0.18) << shift;
  }
}

TEST(NoisyError, CallsADifferenceBelowTheNoiseThatAndNoOther) {
  // 97.7 % of 400 perfect pictures, give or take five times sqrt(400 0.977 0.023) = 15; 1 % is
  // hardly seen beside noise of 3 %, 5 % always.
  EXPECT_NEAR(draw(noisy_case(0)).below_noise, 391, 15);
  EXPECT_GT(draw(noisy_case(0.005)).below_noise, 100);
  EXPECT_EQ(draw(noisy_case(0.05)).below_noise, 0);
}

TEST(NoisyError, WithoutNoiseIsTheRelativeRmse) {
  const Noisy noisy = noisy_case(0.1);
  const NoisyError error = noisy_error(noisy.test, noisy.truth, make_image(40, 30));
  EXPECT_DOUBLE_EQ(error.squared, std::pow(relative_rmse(noisy.test, noisy.truth), 2));
  EXPECT_DOUBLE_EQ(error.relative_rmse, relative_rmse(noisy.test, noisy.truth));
  EXPECT_EQ(error.standard_error, 0);
  EXPECT_FALSE(error.below_noise);
  EXPECT_TRUE(noisy_error(noisy.truth, noisy.truth, make_image(40, 30)).below_noise);
}

TEST(NoisyError, RefusesAReferenceThatIsAllNoise) {
  const Noisy noisy = noisy_case(0);
  Image large = noisy.variance;
  for (float& v : large.values) v = 10;
  EXPECT_THROW(noisy_error(noisy.test, noisy.truth, large), std::runtime_error);
  large.at(3, 3) = -1;
  EXPECT_THROW(noisy_error(noisy.test, noisy.truth, large), std::runtime_error);
  EXPECT_THROW(noisy_error(noisy.test, noisy.truth, make_image(40, 31)), std::runtime_error);
}

TEST(PeakError, OfAShiftIsTheShiftOverThePeak) {
  Image a = make_image(9, 7, 3), b = a;
  for (float& v : b.values) v = 0.25f;
  // 20 log10 4 = 12.0412 dB; a peak of 8 adds 20 log10 8 = 18.0618 dB.
  EXPECT_NEAR(*peak_error(a, b, 1).psnr_db, 12.0412, 1e-4);
  EXPECT_NEAR(*peak_error(a, b, 8).psnr_db, 30.1030, 1e-4);
  EXPECT_DOUBLE_EQ(peak_error(a, b, 8).rms_over_peak, 1.0 / 32);
  EXPECT_FALSE(peak_error(b, b, 1).psnr_db.has_value());
  EXPECT_THROW(peak_error(a, b, 0), std::runtime_error);
}

TEST(Screen, CutsAtWhiteAndEncodes) {
  const Image shown = srgb_of({4, 1, 1, {-1, 0.5f * 50, 50, 800}}, 50);
  EXPECT_EQ(shown.values[0], 0);
  EXPECT_NEAR(shown.values[1], 0.735357, 1e-6);  // 1.055 0.5^(1/2.4) - 0.055
  EXPECT_NEAR(shown.values[2], 1, 1e-6);
  EXPECT_NEAR(shown.values[3], 1, 1e-6);
  EXPECT_THROW(cut_to_screen(shown, 0), std::runtime_error);
}

TEST(MapSummary, IsOfNearestRank) {
  Image map = make_image(20, 10);
  for (std::size_t i = 0; i < 200; ++i) map.values[(77 * i) % 200] = static_cast<float>(i + 1);
  const MapSummary summary = summary_of(map);
  EXPECT_DOUBLE_EQ(summary.mean, 100.5);
  EXPECT_EQ(summary.median, 100);
  EXPECT_EQ(summary.percentile_90, 180);
  EXPECT_EQ(summary.percentile_99, 198);
  EXPECT_EQ(summary.largest, 200);
  EXPECT_EQ(summary_of({1, 1, 1, {3}}).median, 3);
}

TEST(LuminanceError, WeighsTheColorsAsRec709) {
  const Image a = {2, 1, 3, {1, 0, 0, 0, 1, 1}}, b = {2, 1, 3, {0, 0, 0, 0, 2, 0}};
  EXPECT_NEAR(luminance_error(a, b).at(0, 0), 0.2126, 1e-7);
  EXPECT_NEAR(luminance_error(a, b).at(1, 0), 0.7152 - 0.0722, 1e-7);
}

}  // namespace
}  // namespace pluvia
