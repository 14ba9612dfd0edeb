#include "raytrace/spherical_harmonics.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

std::vector<double> harmonics(int degree, const Eigen::Vector3d& direction) {
  std::vector<double> values(harmonic_count(degree));
  real_harmonics(degree, direction, values);
  return values;
}

Eigen::Vector3d at(double z, double phi) {
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(phi), across * std::sin(phi), z};
}

struct GaussPoint {
  double z = 0, weight = 0;
};

// Gauss and Legendre's rule of `count` points on [-1, 1], exact to degree 2 count - 1.
std::vector<GaussPoint> gauss_points(unsigned count) {
  std::vector<GaussPoint> points;
  for (unsigned k = 0; k < count; ++k) {
    double z = std::cos(pi * (k + 0.75) / (count + 0.5)), slope = 0;
    for (int step = 0; step < 20; ++step) {
      slope = count * (z * std::legendre(count, z) - std::legendre(count - 1, z)) / (z * z - 1);
      z -= std::legendre(count, z) / slope;
    }
    points.push_back({z, 2 / ((1 - z * z) * slope * slope)});
  }
  return points;
}

TEST(SphericalHarmonics, AreOrthonormalToTheHighestDegree) {
  // Products are of degree 16: 9 Gauss points in z and 17 equal steps in phi integrate them
  // exactly.
  const int degree = highest_harmonic_degree;
  const std::size_t count = harmonic_count(degree);
  std::vector<double> products(count * count, 0.0);
  for (const GaussPoint& g : gauss_points(9)) {
    for (int k = 0; k < 17; ++k) {
      const auto y = harmonics(degree, at(g.z, 2 * pi * k / 17));
      for (std::size_t i = 0; i < count * count; ++i) {
        products[i] += g.weight * 2 * pi / 17 * y[i / count] * y[i % count];
      }
    }
  }
  // 153 terms of size 1, each rounded some ten times.
  for (std::size_t i = 0; i < count * count; ++i) {
    EXPECT_NEAR(products[i], i / count == i % count ? 1 : 0, 1e-13)
        << i / count << " " << i % count;
  }
}

TEST(SphericalHarmonics, LowDegreesAreTheKnownPolynomials) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d d =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const double x = d.x(), y = d.y(), z = d.z();
    const double a = std::sqrt(1 / (4 * pi)), b = std::sqrt(3 / (4 * pi));
    const double c = std::sqrt(15 / (4 * pi)), e = std::sqrt(5 / (16 * pi));
    const std::vector<double> expected = {a,
                                          b * y,
                                          b * z,
                                          b * x,
                                          c * x * y,
                                          c * y * z,
                                          e * (3 * z * z - 1),
                                          c * x * z,
                                          c / 2 * (x * x - y * y)};
    const auto values = harmonics(2, d);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(values[k], expected[k], 1e-15) << k;
  }
}

TEST(SphericalHarmonics, AllDegreesAreLegendresFunctions) {
  const int degree = highest_harmonic_degree;
  for (const double z : {-0.99, -0.4, 0.0, 0.3, 0.8}) {
    for (const double phi : {0.0, 0.7, 2.5, 4.0}) {
      const auto values = harmonics(degree, at(z, phi));
      for (int l = 0; l <= degree; ++l) {
        for (int m = 0; m <= l; ++m) {
          const double norm =
              std::sqrt((2 * l + 1) / (4 * pi) * std::tgamma(l - m + 1) / std::tgamma(l + m + 1)) *
              (m > 0 ? std::sqrt(2.0) : 1);
          const double p =
              norm * std::assoc_legendre(static_cast<unsigned>(l), static_cast<unsigned>(m), z);
          EXPECT_NEAR(values[harmonic_index(l, m)], p * std::cos(m * phi), 1e-13) << l << " " << m;
          if (m == 0) continue;
          EXPECT_NEAR(values[harmonic_index(l, -m)], p * std::sin(m * phi), 1e-13) << l << " " << m;
        }
      }
    }
  }
}

TEST(SphericalHarmonics, PolesHaveTheAxialTermsAlone) {
  for (const double z : {1.0, -1.0}) {
    const auto values = harmonics(highest_harmonic_degree, {0, 0, z});
    for (int l = 0; l <= highest_harmonic_degree; ++l) {
      for (int m = -l; m <= l; ++m) {
        const double expected = m == 0 ? std::pow(z, l) * std::sqrt((2 * l + 1) / (4 * pi)) : 0;
        EXPECT_NEAR(values[harmonic_index(l, m)], expected, 1e-14) << l << " " << m;
      }
    }
  }
}

TEST(SphericalHarmonics, TurnedCoefficientsAreThoseOfTheTurnedFunction) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  std::vector<double> coefficients(harmonic_count(5));
  for (double& c : coefficients) c = normal(random);
  const auto value = [](const std::vector<double>& c, const Eigen::Vector3d& d) {
    const auto y = harmonics(5, d);
    double sum = 0;
    for (std::size_t k = 0; k < c.size(); ++k) sum += c[k] * y[k];
    return sum;
  };
  for (const double angle : {0.4, -2.0, pi}) {
    const auto turned = turned_about_z(coefficients, angle);
    for (const double phi : {0.1, 1.9, 5.0}) {
      EXPECT_NEAR(value(turned, at(0.3, phi)), value(coefficients, at(0.3, phi - angle)), 1e-13);
    }
  }
}

}  // namespace
}  // namespace pluvia
