#include "validate/streak_statistics.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "validate/wasserstein.h"

namespace pluvia {
namespace {

using Samples = std::vector<WeightedSample>;

Samples evenly(double from, double to, int count) {
  Samples samples;
  for (int i = 0; i < count; ++i) samples.push_back({from + (i + 0.5) / count * (to - from)});
  return samples;
}

TEST(Wasserstein, OfAShiftedDistributionIsTheShift) {
  Samples a = evenly(0, 1, 50), b = a;
  for (WeightedSample& s : b) s.value += 0.3;
  EXPECT_NEAR(wasserstein(a, b), 0.3, 1e-12);
  EXPECT_NEAR(wasserstein(b, a), 0.3, 1e-12);
  EXPECT_EQ(wasserstein(a, a), 0);
}

TEST(Wasserstein, CarriesWeightsByTheShortestWay) {
  // 3/4 at 0, 1/4 at 4 against all at 1: 3/4 by 1, 1/4 by 3.
  EXPECT_NEAR(wasserstein({{0, 3}, {4, 1}}, {{1, 7}}), 1.5, 1e-12);
  // Evenly over 0 .. 1 to its middle: a quarter on average.
  EXPECT_NEAR(wasserstein(evenly(0, 1, 1000), {{0.5}}), 0.25, 1e-12);
}

TEST(Wasserstein, OnACircleGoesTheShorterWayAround) {
  EXPECT_NEAR(circular_wasserstein({{85}}, {{-85}}, 180), 10, 1e-12);
  EXPECT_NEAR(circular_wasserstein({{-5}}, {{40}}, 180), 45, 1e-12);
  EXPECT_NEAR(circular_wasserstein({{0}}, {{90}}, 180), 90, 1e-12);
  EXPECT_NEAR(circular_wasserstein({{10}}, {{190}}, 180), 0, 1e-12);
  // Evenly around to one place: a quarter of the way around, on average.
  EXPECT_NEAR(circular_wasserstein(evenly(0, 180, 1000), {{17}}, 180), 45, 0.1);
  Samples a = {{3, 1}, {60, 2}, {100, 1.5}, {179, 0.5}}, b = a;
  for (WeightedSample& s : b) s.value += 7;
  EXPECT_NEAR(circular_wasserstein(a, b, 180), 7, 1e-12);
}

TEST(Wasserstein, RefusesWhatIsNoDistribution) {
  EXPECT_THROW(wasserstein({}, {{1}}), std::runtime_error);
  EXPECT_THROW(wasserstein({{1, 0}}, {{1}}), std::runtime_error);
  EXPECT_THROW(wasserstein({{1, -1}, {1, 3}}, {{1}}), std::runtime_error);
  EXPECT_THROW(wasserstein({{std::nan("")}}, {{1}}), std::runtime_error);
  EXPECT_THROW(circular_wasserstein({{1}}, {{1}}, 0), std::runtime_error);
}

Plane wave(double u, double v) {
  return Plane::NullaryExpr(96, 128, [&](Eigen::Index y, Eigen::Index x) {
    return 5 + std::cos(2 * std::numbers::pi *
                        (u * static_cast<double>(x) + v * static_cast<double>(y)));
  });
}

TEST(PowerSpectrum, OfWhiteNoiseIsItsVarianceEverywhere) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(2, 0.5);
  const Plane plane = Plane::NullaryExpr(192, 256, [&] { return noise(random); });
  const PowerSpectrum spectrum = power_spectrum(plane);
  // 5 degrees hold some pi/4 192 256 / 36 = 1070 frequencies, each half of a pair that is equal;
  // the window makes neighbours alike, 2.25 = (3/2)^2 of them as one: 1070 / 4.5 = 238
  // independent ones, of a scatter of 1 each. Ring r holds pi/64^2 192 256 (2 r + 1).
  for (const double power : spectrum.sectors) EXPECT_NEAR(power / 0.25, 1, 5 / std::sqrt(238.0));
  for (int r = 0; r < spectrum_rings; ++r) {
    const double independent = std::numbers::pi / 4096 * 192 * 256 * (2 * r + 1) / 4.5;
    EXPECT_NEAR(spectrum.rings[static_cast<std::size_t>(r)] / 0.25, 1, 5 / std::sqrt(independent))
        << r;
  }
}

TEST(PowerSpectrum, OfAWaveLiesInItsRingAndSector) {
  // 0.25 cycles per pixel along x, 0.13 down: hypot = 18.03 / 64 is between rings 17 and 18. Crests
  // lean by -atan(0.52) = -27.5 degrees, the middle of sector 12.
  const PowerSpectrum spectrum = power_spectrum(wave(0.25, 0.13));
  double rings = 0, sectors = 0;
  for (const double p : spectrum.rings) rings += p;
  for (const double p : spectrum.sectors) sectors += p;
  // The window spreads it to the neighbouring frequencies, 1/128 and 1/96 away.
  EXPECT_GT(spectrum.rings[17] + spectrum.rings[18], 0.9 * rings);
  EXPECT_GT(spectrum.sectors[12], 0.9 * sectors);
  EXPECT_GT(power_spectrum(wave(0.25, -0.13)).sectors[23], 0.9 * sectors);
}

TEST(PowerSpectrum, OfATwiceAsBrightPictureIsSixDecibelsAway) {
  const PowerSpectrum one = power_spectrum(wave(0.2, 0.1)),
                      two = power_spectrum(2 * wave(0.2, 0.1));
  EXPECT_NEAR(10 * std::log10(two.rings[14] / one.rings[14]), 6.0206, 1e-4);
  std::mt19937 random(3);
  const Plane noise = Plane::NullaryExpr(64, 64, [&] { return double(random() % 1000); });
  const SpectralDistance distance =
      spectral_distance(power_spectrum(2 * noise), power_spectrum(noise));
  EXPECT_NEAR(distance.rings_db, 6.0206, 1e-4);
  EXPECT_NEAR(distance.sectors_db, 6.0206, 1e-4);
}

TEST(PowerSpectrum, OfPlainPicturesIsNoneWhateverTheirLevel) {
  const Plane dark = Plane::Constant(40, 50, 0.3), light = Plane::Constant(40, 50, 80);
  const PowerSpectrum black = power_spectrum(Plane::Zero(40, 50));
  EXPECT_EQ(spectral_distance(power_spectrum(dark), power_spectrum(light)).rings_db, 0);
  EXPECT_EQ(spectral_distance(black, black).sectors_db, 0);
  EXPECT_EQ(spectral_distance(black, power_spectrum(light)).sectors_db, 0);
  EXPECT_GT(spectral_distance(black, power_spectrum(wave(0.2, 0.1))).rings_db, 10);
  EXPECT_THROW(power_spectrum(Plane::Zero(15, 40)), std::runtime_error);
}

struct Line {
  double lean_deg = 0, sigma_px = 2, height = 3, shift_px = 0;
};

// A line of Gaussian profile through the middle, from border to border.
Image picture_of(const Line& line) {
  Image image = make_image(160, 128);
  const double lean = line.lean_deg * std::numbers::pi / 180;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 160; ++x) {
      const double across =
          (x - 80.3 - line.shift_px) * std::cos(lean) - (y - 64.2) * std::sin(lean);
      image.at(x, y) =
          static_cast<float>(line.height * std::exp(-0.5 * std::pow(across / line.sigma_px, 2)));
    }
  }
  return image;
}

StreakStatistics statistics(const Line& line) {
  return streak_statistics(picture_of(line), 0.1);
}

constexpr double fwhm = 2.354820045;  // of a Gaussian of 1

TEST(StreakStatistics, OfALineAreItsWidthLeanAndBrightness) {
  for (const Line& line : {Line{0, 2, 3}, Line{13, 1.5, 7}, Line{-40, 3, 1}, Line{71, 2.5, 2}}) {
    const StreakStatistics found = statistics(line);
    const double variance = line.sigma_px * line.sigma_px + 1;  // with the blur
    double brightness = 0, width = 0, lean = 0;
    const auto n = static_cast<double>(found.points.size());
    // One point or two in every row, or column, but 13 near the border.
    ASSERT_GT(n, 100) << line.lean_deg;
    for (const RidgePoint& point : found.points) {
      brightness += point.brightness / n, width += point.width_px / n, lean += point.lean_deg / n;
      // Linear interpolation between pixels is off by at most f'' / 8 = height / (8 variance) in
      // each direction; half-way down the slope is 0.59 / sigma, which makes 0.42 / sigma pixels
      // at either side.
      EXPECT_NEAR(point.width_px, fwhm * std::sqrt(variance), 0.84 / std::sqrt(variance));
      // The derivatives are of a sampled Gaussian, cut at four sigma: the slope of the profile
      // comes out alike along x and y to a few 1e-4, and so does the tangent of the lean.
      EXPECT_NEAR(point.lean_deg, line.lean_deg, 0.05);
    }
    // A pixel lies up to half a pixel, or a little more for ties, off the crest.
    const double crest = line.height * line.sigma_px / std::sqrt(variance);
    EXPECT_LT(brightness, crest * 1.001);
    EXPECT_GT(brightness, crest * std::exp(-0.5 * 0.75 * 0.75 / variance)) << line.lean_deg;
    EXPECT_NEAR(width, fwhm * std::sqrt(variance), 0.1) << line.lean_deg;
    EXPECT_NEAR(lean, line.lean_deg, 0.2);
    EXPECT_GT(found.coherence, 0.97);
  }
}

TEST(StreakStatistics, OfARoundDropHaveNoDirectionAndOfNothingNoPoint) {
  Image drop = make_image(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      drop.at(x, y) =
          static_cast<float>(std::exp(-(std::pow(x - 32, 2) + std::pow(y - 32, 2)) / 8));
    }
  }
  // Under the tensor's Gaussian of 3 pixels, the rim of a drop of 2 still has a direction: one of
  // two thirds at most.
  EXPECT_LT(streak_statistics(drop, 0.01).coherence, 0.7);
  for (const RidgePoint& point : streak_statistics(drop, 0.01).points) {
    const bool middle = point.x_px == 32 && point.y_px == 32;
    EXPECT_EQ(middle, point.directed_energy < 1e-12);
  }
  const StreakStatistics none = streak_statistics(make_image(32, 32, 3), 0.1);
  EXPECT_TRUE(none.points.empty());
  EXPECT_EQ(none.coherence, 0);
}

TEST(StatisticsDistance, IsTheDifferenceOfTheLines) {
  const Line line = {5, 2, 3};
  const StreakStatistics reference = statistics(line);
  const StatisticsDistance same = statistics_distance(reference, reference);
  EXPECT_EQ(*same.brightness.value, 0);
  EXPECT_EQ(*same.width_px.value, 0);
  EXPECT_EQ(*same.lean_deg.value, 0);
  EXPECT_EQ(same.spectrum.rings_db, 0);

  const auto bright = statistics_distance(statistics({5, 2, 6}), reference);
  EXPECT_NEAR(*bright.brightness.value, 1, 1e-6);
  EXPECT_NEAR(*bright.width_px.value, 0, 1e-5);
  EXPECT_NEAR(*bright.lean_deg.value, 0, 1e-4);
  EXPECT_NEAR(bright.spectrum.rings_db, 6.02, 0.1);  // but for what is rounding

  const auto turned = statistics_distance(statistics({-7, 2, 3}), reference);
  EXPECT_NEAR(*turned.lean_deg.value, 12, 0.2);
  EXPECT_NEAR(*turned.width_px.value, 0, 0.1);
  EXPECT_NEAR(*turned.brightness.value, 0, 0.02);

  const auto wide = statistics_distance(statistics({5, 3, 3}), reference);
  EXPECT_NEAR(*wide.width_px.value, fwhm * (std::sqrt(10.0) - std::sqrt(5.0)), 0.1);
  EXPECT_GT(wide.spectrum.rings_db, 3);

  const auto moved = statistics_distance(statistics({5, 2, 3, 12}), reference);
  EXPECT_NEAR(*moved.lean_deg.value, 0, 0.05);
  EXPECT_NEAR(*moved.brightness.value, 0, 0.01);
}

TEST(StatisticsDistance, CrossesTheHorizontalByTheShortWay) {
  const auto flat = statistics_distance(statistics({86, 2, 3}), statistics({-87, 2, 3}));
  EXPECT_NEAR(*flat.lean_deg.value, 7, 0.3);
}

TEST(StatisticsDistance, HasNoAnswerWhereOnlyOnePictureHasStreaks) {
  const StreakStatistics none = streak_statistics(make_image(64, 64), 0.1), line = statistics({});
  EXPECT_FALSE(statistics_distance(none, line).width_px.value.has_value());
  EXPECT_FALSE(statistics_distance(line, none).lean_deg.value.has_value());
  EXPECT_EQ(*statistics_distance(none, none).brightness.value, 0);
  EXPECT_FALSE(statistics_distance(line, none).lean_deg.sampling.has_value());
}

// Short streaks of random place, width and lean.
Image shower(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> even(0, 1);
  Image image = make_image(384, 256);
  for (int i = 0; i < 150; ++i) {
    const double cx = 384 * even(random), cy = 256 * even(random), lean = 0.3 * even(random);
    const double sigma = 0.8 + even(random), height = 1 + 3 * even(random);
    for (int y = std::max(0, int(cy) - 30); y < std::min(256, int(cy) + 30); ++y) {
      for (int x = 0; x < 384; ++x) {
        const double across = (x - cx) * std::cos(lean) - (y - cy) * std::sin(lean);
        image.at(x, y) += static_cast<float>(height * std::exp(-0.5 * std::pow(across / sigma, 2)));
      }
    }
  }
  return image;
}

TEST(StatisticsDistance, OfTwoSamplesOfOneRainIsAboutTheStatedSampling) {
  // The same rain twice: on average over eight pairs, the distance is the stated one within a
  // factor of two (streaks that cross a tile's border are in both halves, which makes it less).
  double value = 0, sampling = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto distance = statistics_distance(streak_statistics(shower(2 * seed), 0.2),
                                              streak_statistics(shower(2 * seed + 1), 0.2));
    value += *distance.lean_deg.value / 8, sampling += *distance.lean_deg.sampling / 8;
  }
  EXPECT_GT(value, sampling / 2);
  EXPECT_LT(value, sampling * 2);
}

TEST(StreakStatistics, RefuseWhatHasNoAnswer) {
  Image bad = make_image(32, 32);
  EXPECT_THROW(streak_statistics(bad, 0), std::runtime_error);
  bad.at(3, 3) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(streak_statistics(bad, 1), std::runtime_error);
  EXPECT_THROW(streak_statistics(make_image(32, 32, 4), 1), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
