// What a least-squares fit says about its parameters: a value with its 95 % interval, or that the
// data leave it free, and why. Pure functions.
#pragma once

#include <string>
#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

namespace pluvia {

struct Estimate {
  std::string name = {};  // with its unit: "r0_mm", "A20", "phi_drop_deg"
  std::string why = {};   // the data do not determine it; the numbers below then mean nothing
  double value = 0;
  double low = 0, high = 0;  // 95 %
};

bool is_identifiable(const Estimate& estimate);

// -log10(half the interval / |value|); an angle's against one radian. At least 0, at most 16.
double digits(const Estimate& estimate);

// Half of the 95 % interval in standard errors: the 97.5 % point of Student's t with `freedom` >= 1
// degrees of freedom, to 0.2 % (Abramowitz and Stegun 26.7.5; exact for 1 and 2).
double student_t_95(int freedom);

// Above this, x^T C^-1 x of two jointly estimated parameters differs from zero at 95 %: 2 F(2,
// freedom) = freedom (0.05^(-2 / freedom) - 1), freedom >= 1.
double pair_threshold_95(int freedom);

// 1.4826 median |r|: the standard deviation of normal residuals about zero, blind to nearly half
// of them being outliers. 0 for none.
double robust_scale(std::vector<double> residuals);

// The factor by which the covariance (J^T J)^-1 of the least-squares problem must be multiplied for
// a fit under Cauchy's loss of that width, rho = width^2 / 2 log(1 + r^2 / width^2): Huber, "Robust
// Statistics", 1981, section 7.6:
//   K^2 [sum psi^2 / (n - p)] / [mean psi']^2,   K = 1 + p / n var(psi') / (mean psi')^2.
// n residuals, p < n parameters. Infinite where the residuals are so far out that mean psi' <= 0.
double cauchy_variance(const std::vector<double>& residuals, double width, std::size_t parameters);

struct FitCovariance {
  Eigen::MatrixXd matrix = {};  // (J^T J)^-1; rows and columns of free parameters are zero
  std::vector<bool> free = {};  // it takes part in a direction that changes no residual
};

// Of scalar parameter blocks, at their present values and without the loss. A direction counts as
// free when the residuals change along it by less than 1e-8 of what they do along others (columns
// of J at unit length).
FitCovariance fit_covariance(ceres::Problem& problem, const std::vector<double*>& parameters);

}  // namespace pluvia
