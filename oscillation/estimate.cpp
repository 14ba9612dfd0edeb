#include "oscillation/estimate.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <ceres/covariance.h>
#include <ceres/crs_matrix.h>
#include <Eigen/Dense>

namespace pluvia {

namespace {

bool is_angle(const std::string& name) {
  return name.ends_with("_deg");
}

// The Jacobian without the loss, every column at unit length (zero columns stay).
Eigen::MatrixXd scaled_jacobian(ceres::Problem& problem, const std::vector<double*>& parameters) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = parameters;
  options.apply_loss_function = false;
  ceres::CRSMatrix sparse;
  problem.Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row) {
    const auto begin = static_cast<std::size_t>(sparse.rows[static_cast<std::size_t>(row)]);
    const auto end = static_cast<std::size_t>(sparse.rows[static_cast<std::size_t>(row) + 1]);
    for (std::size_t k = begin; k < end; ++k) jacobian(row, sparse.cols[k]) = sparse.values[k];
  }
  for (Eigen::Index c = 0; c < jacobian.cols(); ++c) {
    const double length = jacobian.col(c).norm();
    if (length > 0) jacobian.col(c) /= length;
  }
  return jacobian;
}

std::vector<bool> free_parameters(const Eigen::MatrixXd& jacobian) {
  constexpr double smallest = 1e-8;  // singular value over the largest
  constexpr double takes_part = 1e-3;
  std::vector<bool> free(static_cast<std::size_t>(jacobian.cols()), false);
  // R of a QR decomposition has the same singular values and right vectors, and is small.
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  const Eigen::Index rows = std::min(jacobian.rows(), jacobian.cols());
  square.topRows(rows) = Eigen::HouseholderQR<Eigen::MatrixXd>(jacobian)
                             .matrixQR()
                             .topRows(rows)
                             .triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(square, Eigen::ComputeFullV);
  for (Eigen::Index k = 0; k < square.cols(); ++k) {
    if (svd.singularValues()[k] > smallest * svd.singularValues()[0]) continue;
    for (Eigen::Index c = 0; c < square.cols(); ++c) {
      if (std::abs(svd.matrixV()(c, k)) > takes_part) free[static_cast<std::size_t>(c)] = true;
    }
  }
  return free;
}

// Ceres's covariance of the parameters that are not free, the others held where they are. False
// where Ceres finds it singular.
bool fill_covariance(ceres::Problem& problem, const std::vector<double*>& parameters,
                     FitCovariance& result) {
  std::vector<std::pair<const double*, const double*>> pairs;
  std::vector<double*> held;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (result.free[i]) {
      if (!problem.IsParameterBlockConstant(parameters[i])) held.push_back(parameters[i]);
      continue;
    }
    for (std::size_t j = i; j < parameters.size(); ++j) {
      if (!result.free[j]) pairs.emplace_back(parameters[i], parameters[j]);
    }
  }
  for (double* const parameter : held) problem.SetParameterBlockConstant(parameter);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.apply_loss_function = false;
  ceres::Covariance covariance(options);
  const bool computed = pairs.empty() || covariance.Compute(pairs, &problem);
  for (std::size_t i = 0; computed && i < parameters.size(); ++i) {
    for (std::size_t j = 0; j < parameters.size(); ++j) {
      if (result.free[i] || result.free[j]) continue;
      covariance.GetCovarianceBlock(
          parameters[i], parameters[j],
          &result.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  for (double* const parameter : held) problem.SetParameterBlockVariable(parameter);
  return computed;
}

}  // namespace

bool is_identifiable(const Estimate& estimate) {
  return estimate.why.empty();
}

double digits(const Estimate& estimate) {
  const double size = is_angle(estimate.name) ? 180 / 3.141592653589793 : std::abs(estimate.value);
  const double half = 0.5 * (estimate.high - estimate.low);
  if (!(half > 0)) return 16;
  return size > half ? std::min(16.0, std::log10(size / half)) : 0;
}

double student_t_95(int freedom) {
  assert(freedom >= 1);
  if (freedom == 1) return 12.706204736;
  if (freedom == 2) return 4.302652730;
  constexpr double z = 1.959963985, z2 = z * z;
  const double v = freedom;
  return z * (1 + (z2 + 1) / (4 * v) + ((5 * z2 + 16) * z2 + 3) / (96 * v * v) +
              (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * v * v * v) +
              ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) / (92160 * v * v * v * v));
}

double pair_threshold_95(int freedom) {
  assert(freedom >= 1);
  return freedom * std::expm1(-2.0 / freedom * std::log(0.05));
}

double robust_scale(std::vector<double> residuals) {
  if (residuals.empty()) return 0;
  for (double& r : residuals) r = std::abs(r);
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return 1.4826 * *middle;
}

double cauchy_variance(const std::vector<double>& residuals, double width, std::size_t parameters) {
  assert(parameters < residuals.size() && width > 0);
  const double n = static_cast<double>(residuals.size()), p = static_cast<double>(parameters);
  double psi_square = 0, slope = 0, slope_square = 0;
  for (const double r : residuals) {
    const double q = r * r / (width * width), weight = 1 / (1 + q);
    const double psi_slope = (1 - q) * weight * weight;
    psi_square += r * r * weight * weight;
    slope += psi_slope / n;
    slope_square += psi_slope * psi_slope / n;
  }
  if (!(slope > 0)) return std::numeric_limits<double>::infinity();
  const double k = 1 + p / n * (slope_square - slope * slope) / (slope * slope);
  return k * k * psi_square / (n - p) / (slope * slope);
}

FitCovariance fit_covariance(ceres::Problem& problem, const std::vector<double*>& parameters) {
  FitCovariance result;
  const auto n = static_cast<Eigen::Index>(parameters.size());
  result.matrix = Eigen::MatrixXd::Zero(n, n);
  result.free = free_parameters(scaled_jacobian(problem, parameters));
  if (!fill_covariance(problem, parameters, result)) {
    result.matrix.setZero();
    result.free.assign(parameters.size(), true);
  }
  return result;
}

}  // namespace pluvia
