// Errors of streak pictures against a much finer run: what generator_accuracy and database_accuracy
// measure.
#pragma once

#include <string>
#include <vector>

#include "atlas/streak_database.h"

namespace pluvia {

struct LightError {
  std::string shard = {}, light = {};
  double flux = 0;                // of the reference, sum over its pixels; 0: it is dark
  double image = 0;               // relative RMSE: sqrt(sum of squared differences / of squares)
  double flux_error = 0;          // relative, signed
  double estimate = 0;            // of the relative RMSE, by the run's own variances
  double reference_estimate = 0;  // the same of the reference
};

LightError light_error(const StreakImage& ours, const StreakImage& reference);

// "median / 90th percentile / greatest" of one figure's size, in per cent; "none" of no errors.
std::string spread(const std::vector<LightError>& errors, double LightError::*figure);

// Of all lights' light together.
double total_flux_error(const std::vector<LightError>& errors);

}  // namespace pluvia
