#include "oscillation/size_distribution.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "oscillation/fall_speed.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// Simpson's rule over the diameters, an integration of its own.
double integral(const SizeDistribution& rain, double low_m, auto weight) {
  constexpr int n = 4000;
  std::vector<double> d;
  for (int i = 0; i <= n; ++i) d.push_back(low_m + (largest_diameter_m - low_m) * i / n);
  const std::vector<double> number = drops_per_m4(rain, d);
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double at = d[k] > 0 ? number[k] * weight(d[k]) : 0;
    sum += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * at;
  }
  return sum * (largest_diameter_m - low_m) / n / 3;
}

TEST(SizeDistribution, TheRateIsTheOneAskedFor) {
  for (const SizeLaw law : {SizeLaw::marshall_palmer, SizeLaw::willis}) {
    for (const double rate : {0.01, 1.0, 10.0, 100.0, 300.0}) {
      const double flux_m_s = integral(
          {law, rate}, 1e-6, [](double d) { return pi / 6 * d * d * d * fall_speed_m_s(d); });
      EXPECT_NEAR(flux_m_s * 3.6e6 / rate, 1, 1e-4) << rate;
    }
  }
}

TEST(SizeDistribution, ExtinctionIsThePublishedOneButForTheRescaling) {
  // data: Marshall-Palmer at 10 mm/h, 0.01 .. 8 mm: 1.5556e-3 /m at Q = 2 for the 11.6255 mm/h
  // that the law gives; 3e-4 of it are drops beyond 7 mm, of the rate 2e-3.
  const double sigma = extinction_per_m({SizeLaw::marshall_palmer, 10});
  EXPECT_NEAR(sigma, 1.5556e-3 / 2 * 10 / 11.6255, 3e-3 * sigma);
  const double willis = extinction_per_m({SizeLaw::willis, 10});
  EXPECT_NEAR(willis, 1.1852e-3 / 2 * 10 / 10.7797, 3e-3 * willis);
}

TEST(SizeDistribution, ClassesHoldNumberAndExtinctionOfWhatTheyStandFor) {
  for (const SizeLaw law : {SizeLaw::marshall_palmer, SizeLaw::willis}) {
    for (const int count : {1, 4, 16}) {
      const SizeDistribution rain = {law, 10};
      const auto classes = size_classes(rain, count, 0.5e-3);
      ASSERT_EQ(classes.size(), static_cast<std::size_t>(count));
      double number = 0, sigma = 0, before_m = 0.5e-3;
      for (const SizeClass& one : classes) {
        EXPECT_GT(one.diameter_m, before_m);
        EXPECT_DOUBLE_EQ(one.fall_speed_m_s, fall_speed_m_s(one.diameter_m));
        before_m = one.diameter_m;
        number += one.drops_per_m3;
        sigma += pi / 4 * one.diameter_m * one.diameter_m * one.drops_per_m3;
      }
      EXPECT_NEAR(number, integral(rain, 0.5e-3, [](double) { return 1; }), 1e-5 * number);
      EXPECT_NEAR(sigma, extinction_per_m(rain, 0.5e-3), 1e-12);
    }
  }
}

TEST(SizeDistribution, ClassesHaveEqualShares) {
  const auto classes = size_classes({SizeLaw::marshall_palmer, 10}, 4, 0.5e-3);
  const auto share = [](const SizeClass& c) {
    return c.diameter_m * c.diameter_m * c.drops_per_m3;
  };
  // Half a step of 1 um at either end, where a step holds a thousandth of a class.
  for (const SizeClass& c : classes) EXPECT_NEAR(share(c) / share(classes[0]), 1, 3e-3);
}

TEST(SizeDistribution, WhatIsOutOfRangeIsRefused) {
  for (const double rate : {0.0, -1.0, 301.0, std::nan("")})
    EXPECT_THROW(extinction_per_m({SizeLaw::willis, rate}), std::invalid_argument);
  for (const int count : {0, 17})
    EXPECT_THROW(size_classes({}, count, 1e-3), std::invalid_argument);
  for (const double least_m : {0.0, 7e-3, std::nan("")})
    EXPECT_THROW(size_classes({}, 4, least_m), std::invalid_argument);
  EXPECT_EQ(drops_per_m4({}, {0.0, 8e-3}), (std::vector<double>{0, 0}));
}

}  // namespace
}  // namespace pluvia
