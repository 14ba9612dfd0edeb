// A streak's brightness as a few numbers that change smoothly with the drop
// (validate/streak_fit.h).
#pragma once

#include <vector>

#include "raytrace/streak_frame.h"

namespace pluvia {

// Points along the fall, 2 standard deviations of the blur apart.
int feature_points(const StreakFrame& frame);

// Neighbouring points of blurred white noise are correlated by exp(-1), the next by exp(-4): n of
// them say as much as n / (1 + 2 exp(-1) + 2 exp(-4)) independent ones.
constexpr double feature_correlation = 1.7724;

// sqrt(F + e) of every point, then M / sqrt(F + e), M in units of the frame's width. values: width
// * height of the frame, >= 0. Scales with the square root of the brightness.
std::vector<double> streak_features(const StreakFrame& frame, const std::vector<double>& values);

}  // namespace pluvia
