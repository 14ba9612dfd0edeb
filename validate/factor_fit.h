// What the real factors say about the one unknown of the rigid sphere: the cone of the 2006 light,
// fitted with Ceres (and the unit of the factors with it) on light elevations 10 and 90. Elevation
// 50 is kept for judging.
//
// A residual is log10(ours / theirs) of one factor, ours the maximum pixel of a streak that is
// traced anew for every trial. A maximum is not smooth, so derivatives are differences over steps
// of 2 %.
#pragma once

#include <string>
#include <vector>

#include "raytrace/generate.h"
#include "validate/amplitude_fit.h"
#include "validate/real_factors.h"

namespace pluvia {

struct FittedValue {
  std::string name = {};  // the preset's key
  double start = 0, value = 0;
  double standard_error = 0;  // from the covariance, scaled by the residuals
  bool identifiable = true;   // false: the factors do not determine it; value is the start
};

struct FactorFit {
  FittedValue cone = {};
  double log10_constant = 0;             // the unit: log10(ours / theirs) of all factors
  double rms_before = 0, rms_after = 0;  // over the fitted factors
  bool converged = true;                 // within the solver's iterations
};

// Starts from the preset's cone. Throws std::runtime_error without factors of set 0 and elevation
// 10 or 90.
FactorFit fit_factors(const Preset& preset, const std::vector<RealFactor>& factors);

// JSON with a version number.
void write_factor_fit(const std::string& file, const FactorFit& fit,
                      const AmplitudeFit& amplitudes);

}  // namespace pluvia
