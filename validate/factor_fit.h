// What the real factors say about the unknowns of the 2006 database, fitted with Ceres on light
// elevations 10 and 90 (elevation 50 is kept for judging): first the cone of the light, on the
// rigid sphere; then, with that cone, A20 and A31 of each pair of oscillation sets that share them
// and look in opposite directions.
//
// A residual is log10(ours / theirs) of one factor, ours the maximum pixel of a streak that is
// traced anew for every trial. A maximum is not smooth, so derivatives are differences over steps
// of 2 %.
#pragma once

#include <string>
#include <vector>

#include "raytrace/generate.h"
#include "validate/real_factors.h"

namespace pluvia {

struct FittedValue {
  std::string name = {};  // "cone_half_angle_deg", "A20 of sets 2, 4", ..
  double start = 0, value = 0;
  double standard_error = 0;  // from the covariance, scaled by the residuals
  bool identifiable = true;   // false: the factors do not determine it; value is the start
};

struct FactorFit {
  std::vector<FittedValue> values = {};
  double log10_constant = 0;             // one unit for all factors, from the rigid sphere
  double rms_before = 0, rms_after = 0;  // over the fitted factors
  bool converged = true;                 // every problem, within its iterations
};

// Starts from the preset's values. Throws std::runtime_error when the factors lack elevation 10
// or 90.
FactorFit fit_factors(const Preset& preset, const std::vector<RealFactor>& factors,
                      const Progress& progress = {});

// JSON with a version number.
void write_factor_fit(const std::string& file, const FactorFit& fit);

}  // namespace pluvia
