#include "oscillation/mode_estimates.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Dense>

namespace pluvia {

namespace {

constexpr double degree = std::numbers::pi / 180;

}  // namespace

Estimate undetermined(const std::string& name, const std::string& why) {
  return {.name = name, .why = why};
}

Estimate bounded_estimate(const std::string& name, double value, double half_width, double widest,
                          const std::string& unit) {
  if (half_width <= widest) return {name, "", value, value - half_width, value + half_width};
  return undetermined(name, fmt::format("its 95 % interval would be +-{:.2g}{}", half_width, unit));
}

bool add_mode_estimates(const ModePair& mode, int freedom, double widest,
                        std::vector<Estimate>& values) {
  const std::string amplitude = fmt::format("A{}", mode.label);
  const std::string phase = fmt::format("phase{}_deg", mode.label);
  if (mode.free) {
    values.push_back(undetermined(amplitude, left_free));
    values.push_back(undetermined(phase, left_free));
    return false;
  }
  const Eigen::Matrix2d& c = mode.covariance;
  const double t = student_t_95(freedom), size = mode.ab.norm();
  const bool differs = mode.ab.dot(c.ldlt().solve(mode.ab)) > pair_threshold_95(freedom);
  Eigen::Vector2d along = {1, 0};
  if (differs) {
    along = mode.ab / size;
  } else {  // no direction of its own: the widest
    along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(c).eigenvectors().col(1);
  }
  values.push_back(
      bounded_estimate(amplitude, size, t * std::sqrt(along.dot(c * along)), widest, ""));
  values.back().low = differs ? std::max(0.0, values.back().low) : 0;
  if (!differs) {
    values.push_back(undetermined(phase, "the amplitude cannot be told from zero"));
    return false;
  }
  const Eigen::Vector2d across = {-along[1], along[0]};
  values.push_back(bounded_estimate(phase, std::atan2(mode.ab[1], mode.ab[0]) / degree,
                                    t * std::sqrt(across.dot(c * across)) / size / degree, 90,
                                    " deg"));
  return true;
}

const Estimate& estimate_of(const std::vector<Estimate>& values, const std::string& name) {
  const auto at =
      std::find_if(values.begin(), values.end(), [&](const Estimate& e) { return e.name == name; });
  if (at == values.end()) throw std::out_of_range(fmt::format("no estimate of {}", name));
  return *at;
}

}  // namespace pluvia
