// The statistics behind every interval, against tables and simulation.
#include "oscillation/estimate.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "tests/outline_samples.h"

namespace pluvia {
namespace {

TEST(Estimate, StudentsTIsThatOfTheTables) {
  // Abramowitz and Stegun, table 26.10, 97.5 %.
  const std::vector<std::pair<int, double>> table = {{1, 12.706}, {2, 4.303},  {3, 3.182},
                                                     {4, 2.776},  {5, 2.571},  {8, 2.306},
                                                     {20, 2.086}, {120, 1.980}};
  for (const auto& [freedom, t] : table) {
    EXPECT_NEAR(student_t_95(freedom), t, 2e-3 * t) << freedom;
  }
  EXPECT_NEAR(student_t_95(1000000), 1.959964, 1e-5);
}

TEST(Estimate, ThePairThresholdIsTwiceFishersF) {
  // F(2, 10) at 95 % = 4.103, F(2, 1) = 199.5; chi-square with two degrees 5.9915.
  EXPECT_NEAR(pair_threshold_95(10), 2 * 4.103, 1e-3);
  EXPECT_NEAR(pair_threshold_95(1), 2 * 199.5, 0.1);
  EXPECT_NEAR(pair_threshold_95(1000000), 5.9915, 1e-3);
}

TEST(Estimate, TheRobustScaleIsTheStandardDeviationOfNormalResiduals) {
  Random random(5);
  std::vector<double> residuals;
  for (int k = 0; k < 20000; ++k) residuals.push_back(0.3 * normal(random));
  // The median's own error: 1.17 / sqrt(n) = 0.8 % (efficiency 0.37 of 1 / sqrt(2 n)); 4 of them.
  EXPECT_NEAR(robust_scale(residuals), 0.3, 0.3 * 4 * 0.0083);
  for (int k = 0; k < 4000; ++k) residuals[static_cast<std::size_t>(k)] = 1e6;
  // With 20 % outliers the median is the 62.5 % point of |normal| (of the other 80 %): 0.887 /
  // 0.6745.
  EXPECT_NEAR(robust_scale(residuals), 0.3 * 0.887 / 0.6745, 0.01);
  EXPECT_EQ(robust_scale({}), 0);
}

TEST(Estimate, DigitsAreThoseOfTheIntervalOverTheValue) {
  EXPECT_NEAR(digits({"A20", "", 0.1, 0.099, 0.101}), 2, 1e-9);
  EXPECT_NEAR(digits({"phi_drop_deg", "", 0.0, -0.57295779513, 0.57295779513}), 2, 1e-9);
  EXPECT_EQ(digits({"A20", "", 0.0, -1, 1}), 0);
  EXPECT_EQ(digits({"A20", "", 0.1, 0.1, 0.1}), 16);
}

// y = x0 + x1 t (+ x2 t): x2 repeats x1.
struct Line {
  double t = 0, y = 0;
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* r) const {
    r[0] = a[0] + b[0] * t + c[0] * (2 * t) - y;
    return true;
  }
};

TEST(Estimate, ADirectionThatChangesNothingIsFreeAndTheRestKeepsItsCovariance) {
  double a = 1, b = 2, c = 3;
  ceres::Problem problem;
  for (const double t : {-1.0, 0.0, 1.0, 2.0}) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Line, 1, 1, 1, 1>(new Line{t, 0}),
                             new ceres::CauchyLoss(0.1), &a, &b, &c);
  }
  const FitCovariance result = fit_covariance(problem, {&a, &b, &c});
  EXPECT_EQ(result.free, (std::vector<bool>{false, true, true}));
  // The remaining column of J is four ones: variance 1/4, whatever the loss.
  EXPECT_NEAR(result.matrix(0, 0), 0.25, 1e-12);
  EXPECT_EQ(result.matrix(1, 1), 0);
  EXPECT_FALSE(problem.IsParameterBlockConstant(&b));
  problem.SetParameterBlockConstant(&c);
  const FitCovariance line = fit_covariance(problem, {&a, &b});
  EXPECT_EQ(line.free, (std::vector<bool>{false, false}));
  // (J^T J)^-1 of t = -1, 0, 1, 2: det = 4 * 6 - 2 * 2 = 20.
  EXPECT_NEAR(line.matrix(0, 0), 6.0 / 20, 1e-12);
  EXPECT_NEAR(line.matrix(1, 1), 4.0 / 20, 1e-12);
  EXPECT_NEAR(line.matrix(0, 1), -2.0 / 20, 1e-12);
}

TEST(Estimate, CauchysVarianceIsThatOfSimulatedLocations) {
  // The location of 50 normal samples under Cauchy's loss, 2000 times. Its variance is known to
  // sqrt(2 / 2000) = 3.2 %; Huber's formula is itself good to some 2 % at n = 50: 4 * 3.2 + 2 = 15
  // %.
  Random random(8);
  double square = 0, predicted = 0;
  const int trials = 2000, n = 50;
  for (int k = 0; k < trials; ++k) {
    std::vector<double> sample;
    for (int i = 0; i < n; ++i) sample.push_back(normal(random));
    double x = 0;
    for (int round = 0; round < 40; ++round) {  // reweighting
      double sum = 0, weights = 0;
      for (const double y : sample) {
        const double w = 1 / (1 + (y - x) * (y - x) / (2.3849 * 2.3849));
        sum += w * y;
        weights += w;
      }
      x = sum / weights;
    }
    for (double& y : sample) y -= x;
    square += x * x / trials;
    predicted += cauchy_variance(sample, 2.3849, 1) / n / trials;
  }
  EXPECT_NEAR(predicted / square, 1, 0.15);
}

}  // namespace
}  // namespace pluvia
