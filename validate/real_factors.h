// The real numbers of the 2006 database: 190 brightness factors (the maximum pixel of a point-light
// streak) of camera elevation 0, against ours.
#pragma once

#include <string>
#include <vector>

#include "atlas/streak_database.h"

namespace pluvia {

struct RealFactor {
  LightDirection light = {};
  int oscillation = 0;
  double factor = 0;  // > 0, unit unknown
};

// data/factors/*.csv: light_elevation_deg, light_azimuth_deg, osc0 .. osc9.
// Throws std::runtime_error "FILE:LINE: found; expected".
std::vector<RealFactor> read_real_factors(const std::string& file);

struct FactorResidual {
  RealFactor real = {};
  double log10_ratio = 0;  // log10(ours / theirs) after the one global constant
};

struct FactorComparison {
  double log10_constant = 0;  // fitted on elevations 10 and 90, all given oscillations
  std::vector<FactorResidual> residuals = {};  // every factor
};

// Ours is the maximum of the light's picture in the database's 32 px shards of view elevation 0.
// The one constant is the mean of log10(ours / theirs) over the factors of the fit elevations.
FactorComparison compare_factors(const std::string& database_folder, const Manifest& manifest,
                                 const std::vector<RealFactor>& factors);

// Root mean square of the residuals of one oscillation (-1: all) at one light elevation.
double factor_rms(const FactorComparison& comparison, int oscillation, int light_elevation_deg);

}  // namespace pluvia
