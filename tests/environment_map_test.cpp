#include "raytrace/environment_map.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "atlas/image_io.h"
#include "raytrace/spherical_harmonics.h"
#include "tests/band_limited_map.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

EnvironmentMap random_map(int height, int channels) {
  std::mt19937 random(3);
  std::exponential_distribution<float> value(1);
  EnvironmentMap map = {.radiance = make_image(2 * height, height, channels)};
  for (float& v : map.radiance.values) v = value(random);
  return map;
}

std::vector<double> radiance(const EnvironmentMap& map, const Eigen::Vector3d& direction) {
  std::vector<double> values(static_cast<std::size_t>(map.radiance.channels));
  look_up(map, direction, values);
  return values;
}

TEST(EnvironmentMap, PixelCentresLieWhereImageIoSays) {
  const EnvironmentMap map = random_map(6, 2);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 12; ++x) {
      const double azimuth = 2 * pi * ((x + 0.5) / 12 - 0.5),
                   elevation = pi * (0.5 - (y + 0.5) / 6);
      const Eigen::Vector3d d = {std::cos(elevation) * std::cos(azimuth),
                                 -std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
      EXPECT_NEAR((d - map_direction(map.radiance, x + 0.5, y + 0.5)).norm(), 0, 1e-15);
      for (int c = 0; c < 2; ++c) {
        EXPECT_NEAR(radiance(map, d)[static_cast<std::size_t>(c)], map.radiance.at(x, y, c), 1e-12);
      }
    }
  }
}

TEST(EnvironmentMap, RadianceIsBilinearAlsoOverTheSeamAndThePoles) {
  const EnvironmentMap map = random_map(6, 1);
  const Image& image = map.radiance;
  const auto mean = [](double a, double b) { return (a + b) / 2; };
  // Column 12 is the seam, between the centres of columns 11 and 0.
  EXPECT_NEAR(radiance(map, map_direction(image, 12, 2.5))[0],
              mean(image.at(11, 2), image.at(0, 2)), 1e-12);
  EXPECT_NEAR(radiance(map, map_direction(image, 4, 3))[0],
              mean(mean(image.at(3, 2), image.at(4, 2)), mean(image.at(3, 3), image.at(4, 3))),
              1e-12);
  // On the meridian of column 1's centre, at the pole itself: half of it, half of column 7.
  const Eigen::Vector3d near = map_direction(image, 1.5, 1e-9);
  EXPECT_NEAR(radiance(map, near)[0], mean(image.at(1, 0), image.at(7, 0)), 1e-8);
  EXPECT_TRUE(std::isfinite(radiance(map, {0, 0, 1})[0]));
  EXPECT_NEAR(radiance(map, map_direction(image, 1.5, 6 - 1e-9))[0],
              mean(image.at(1, 5), image.at(7, 5)), 1e-8);
}

TEST(EnvironmentMap, ItsFrameTurnsDirectionsIntoTheWorld) {
  EnvironmentMap map = random_map(8, 1);
  const EnvironmentMap straight = map;
  map.world_from_drop = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  const Eigen::Vector3d d = Eigen::Vector3d(-0.2, 0.5, 0.4).normalized();
  EXPECT_NEAR(radiance(map, d)[0], radiance(straight, map.world_from_drop * d)[0], 1e-12);
}

TEST(EnvironmentMap, UniformLightHasTheConstantTermAlone) {
  // Also where a pixel is as large as the sphere's half: pieces of pi / 64 at two Gauss points are
  // off by (9 pi / 64)^4 / 4320 = 9e-6 of sqrt(4 pi) at degree 8.
  for (const int height : {1, 5, 64}) {
    EnvironmentMap map = {.radiance = make_image(2 * height, height)};
    for (float& v : map.radiance.values) v = 2;
    const auto c = harmonic_coefficients(map, 8)[0];
    EXPECT_NEAR(c[0], 2 * std::sqrt(4 * pi), 1e-6) << height;
    for (std::size_t k = 1; k < c.size(); ++k) EXPECT_NEAR(c[k], 0, 6e-5) << height << " " << k;
  }
}

TEST(EnvironmentMap, ConstantTermIsTheMeanOverTheSphere) {
  const EnvironmentMap map = random_map(32, 3);
  const auto mean = mean_over_sphere(map.radiance);
  const auto c = harmonic_coefficients(map, 0);
  // Two Gauss points for the cosine in rows of pi / 64: (pi / 64)^4 / 4320 = 1e-9.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(c[k][0] / (std::sqrt(4 * pi) * mean[k]), 1, 1e-8);
}

TEST(EnvironmentMap, CoefficientsOfABandLimitedMapComeBack) {
  // Pixels of side h hold f at their centres for f all over them. To second order a pixel's
  // integral of f g, g = Y cos(elevation), is off by h^2 / 12 times (f'' g / 2 + f' g') of either
  // axis; with Bernstein's |f'| <= l M, |f''| <= l^2 M and the same with l + 1 for g, |Y| <=
  // sqrt((2 l + 1) / 4 pi), and 2 pi^2 for the area of the map: less than (l + 1)^2 h^2 M sqrt((2 l
  // + 1) / 4 pi) pi^2 / 2.
  const int degree = 4, height = 128;
  const BandLimited f = band_limited(degree, 11);
  EnvironmentMap map;
  map.world_from_drop = Eigen::AngleAxisd(-1.1, Eigen::Vector3d(0.3, -1, 2).normalized()).matrix();
  map.radiance = picture_of(f, map.world_from_drop, height);
  const auto c = harmonic_coefficients(map, degree)[0];
  const double h = pi / height;
  const double bound = std::pow((degree + 1) * h, 2) * f.largest *
                       std::sqrt((2 * degree + 1) / (4 * pi)) * pi * pi / 2;
  double largest = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    EXPECT_NEAR(c[k], f.coefficients[k], bound) << k;
    if (k > 0) largest = std::max(largest, std::abs(f.coefficients[k]));
  }
  EXPECT_GT(largest, 2 * bound) << "nothing was tested";
}

TEST(EnvironmentMap, TurningTheMapTurnsItsCoefficients) {
  EnvironmentMap map = random_map(16, 1);
  const auto straight = harmonic_coefficients(map, 4)[0];
  // Seen from a frame turned by a about z, everything has turned by -a.
  const double a = 0.9;
  map.world_from_drop = Eigen::AngleAxisd(a, Eigen::Vector3d::UnitZ()).matrix();
  const auto seen = harmonic_coefficients(map, 4)[0];
  const auto turned = turned_about_z(straight, -a);
  for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_NEAR(seen[k], turned[k], 1e-11) << k;
}

}  // namespace
}  // namespace pluvia
