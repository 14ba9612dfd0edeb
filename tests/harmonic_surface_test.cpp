#include "oscillation/harmonic_surface.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// One harmonic P_{n,m}(cos theta) (cosine cos m phi + sine sin m phi).
template <typename T>
HarmonicSurface<T> one_harmonic(int n, int m, const T& cosine, const T& sine) {
  HarmonicSurface<T> surface;
  add_harmonic(surface, m, n - m, legendre_derivative(n, m), cosine, sine);
  return surface;
}

Eigen::Vector3d at_angles(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(HarmonicSurface, EveryModeIsTheStandardLibrarysLegendreFunctionTimesCosAndSin) {
  // std::assoc_legendre has no Condon-Shortley sign either. Rounding grows with the size of the
  // coefficients: those of n = 10 reach 1e9 for m = n, so the tolerance is relative to the largest
  // |P| (bounded by (2 n - 1)!! of m = n).
  for (int n = 0; n <= max_harmonic_degree; ++n) {
    for (int m = 0; m <= n; ++m) {
      const auto surface = one_harmonic(n, m, 0.7, -0.4);
      double largest = 1, worst = 0;
      for (int i = 0; i <= 40; ++i) {
        const double theta = pi * i / 40, phi = 0.3 + 0.1 * i;
        const auto order = static_cast<unsigned>(m);
        const double p = std::assoc_legendre(static_cast<unsigned>(n), order, std::cos(theta));
        const double expected = p * (0.7 * std::cos(m * phi) - 0.4 * std::sin(m * phi));
        largest = std::max(largest, std::abs(p));
        worst = std::max(worst, std::abs(evaluate(surface, at_angles(theta, phi)).h - expected));
      }
      EXPECT_LT(worst, 1e-13 * largest) << "n " << n << ", m " << m;
    }
  }
}

TEST(HarmonicSurface, ChebyshevTermsAreCosinesOfMultiples) {
  for (int k = 0; k <= max_harmonic_degree; ++k) {
    HarmonicSurface<double> surface;
    add_harmonic(surface, 0, k, chebyshev(k), 1.0, 0.0);
    for (double theta = 0; theta <= pi; theta += 0.1) {
      EXPECT_NEAR(evaluate(surface, at_angles(theta, 1)).h, std::cos(k * theta), 2e-12)
          << "k " << k << ", theta " << theta;
    }
  }
}

// A surface with all orders, added out of order and some twice.
template <typename T>
HarmonicSurface<T> full_surface() {
  HarmonicSurface<T> surface;
  for (int n : {8, 3, 5, 2, 7, 6, 4}) {
    for (int m = n; m >= 0; m -= 2) {
      add_harmonic(surface, m, n - m, legendre_derivative(n, m), T(0.1 / (1 + n * m)),
                   T(0.03 / (1 + n * m)));
    }
  }
  return surface;
}

TEST(HarmonicSurface, OrdersStayAscendingAndEqualOnesJoinWhateverTheOrderOfAddition) {
  const auto surface = full_surface<double>();
  ASSERT_EQ(surface.order_count, 9);  // m = 0 .. 8
  for (int m = 0; m < 9; ++m) EXPECT_EQ(surface.orders[static_cast<std::size_t>(m)].m, m);
  HarmonicSurface<double> sum;
  double separate = 0;
  const Eigen::Vector3d u = at_angles(0.9, 2);
  for (int n : {4, 2, 3}) {
    add_harmonic(sum, 2, n - 2, legendre_derivative(n, 2), 0.1 * n, 0.2);
    separate += evaluate(one_harmonic(n, 2, 0.1 * n, 0.2), u).h;
  }
  EXPECT_EQ(sum.order_count, 1);
  EXPECT_NEAR(evaluate(sum, u).h, separate, 1e-15);
}

TEST(HarmonicSurface, GradientAndHessianAreCentralDifferencesEverywhereAlsoAtThePoles) {
  // Step 1e-5: truncation ~ 1e-10 third derivatives (n^3 ~ 5e2), rounding ~ 1e-16 / 1e-5.
  const auto surface = full_surface<double>();
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d u = i == 0   ? Eigen::Vector3d(0, 0, 1)
                              : i == 1 ? Eigen::Vector3d(0, 0, -1)
                                       : random_direction(random);
    const auto value = evaluate(surface, u);
    const Eigen::Matrix3d second = hessian(surface, u);
    const double scale = std::max(1.0, second.norm());
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      const auto above = evaluate<double>(surface, u + step);
      const auto below = evaluate<double>(surface, u - step);
      EXPECT_NEAR(value.gradient[k], (above.h - below.h) / 2e-5, 1e-6 * scale) << u.transpose();
      const Eigen::Vector3d column = (above.gradient - below.gradient) / 2e-5;
      EXPECT_LT((second.col(k) - column).norm(), 1e-6 * scale) << u.transpose();
    }
  }
}

TEST(HarmonicSurface, TheSameFormulaServesLongDoublesAndJets) {
  using Jet = ceres::Jet<double, 3>;
  const auto plain = full_surface<double>();
  const auto wide = full_surface<long double>();
  const auto jets = full_surface<Jet>();
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d u = random_direction(random);
    const auto value = evaluate(plain, u);
    const Eigen::Matrix<long double, 3, 1> wide_u = u.cast<long double>();
    // Both add some 20 terms of size <= 1e3 (coefficients of degree 8): 1e3 * 20 * 1e-16.
    EXPECT_NEAR(static_cast<double>(evaluate(wide, wide_u).h), value.h, 2e-12);
    const Eigen::Matrix<Jet, 3, 1> jet_u = {Jet(u.x(), 0), Jet(u.y(), 1), Jet(u.z(), 2)};
    const Jet h = evaluate(jets, jet_u).h;
    EXPECT_NEAR(h.a, value.h, 1e-12);
    // The hand-written gradient against automatic differentiation.
    EXPECT_LT((h.v - value.gradient).norm(), 1e-10) << u.transpose();
  }
}

TEST(HarmonicSurface, AnAmplitudeMayBeTheVariableOfDifferentiation) {
  // dh/dA of A P_{3,1} cos phi is P_{3,1} cos phi: what a fit of amplitudes rests on.
  using Jet = ceres::Jet<double, 1>;
  const auto surface = one_harmonic(3, 1, Jet(0.1, 0), Jet(0.0));
  const Eigen::Vector3d u = at_angles(0.7, 0.4);
  const Eigen::Matrix<Jet, 3, 1> jet_u = u.cast<Jet>();
  const double p31 = std::assoc_legendre(3u, 1u, std::cos(0.7)) * std::cos(0.4);
  EXPECT_NEAR(evaluate(surface, jet_u).h.v[0], p31, 1e-14);
  EXPECT_NEAR(evaluate(surface, jet_u).h.a, 0.1 * p31, 1e-15);
}

}  // namespace
}  // namespace pluvia
