// Amplitude, phase and direction of a drop's modes from a fit of a sin wt + b cos wt: which of them
// the data determine, and how well. Shared by all fits of oscillations.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "oscillation/estimate.h"

namespace pluvia {

// Why the data leave a parameter free: it takes part in a direction that changes no residual.
inline constexpr const char* left_free = "the data leave it free";

Estimate undetermined(const std::string& name, const std::string& why);

// The value with its 95 % interval; undetermined when that is wider than +- widest.
Estimate bounded_estimate(const std::string& name, double value, double half_width, double widest,
                          const std::string& unit);

struct ModePair {
  std::string label = {};       // "20"
  Eigen::Vector2d ab = {0, 0};  // of sin, cos; relative to r0
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  bool free = false;  // a or b takes part in a free direction
};

// Appends A<label> >= 0 and phase<label>_deg. The phase is undetermined where the amplitude does
// not differ from zero at 95 %; an amplitude wider than +- widest is undetermined. True when the
// amplitude differs from zero.
bool add_mode_estimates(const ModePair& mode, int freedom, double widest,
                        std::vector<Estimate>& values);

// The one of that name. Throws std::out_of_range when there is none.
const Estimate& estimate_of(const std::vector<Estimate>& values, const std::string& name);

}  // namespace pluvia
