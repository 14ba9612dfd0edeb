// A streak to a stated error: the coarsest of a ladder of settings whose own estimate keeps it.
//
// The error of a streak is its relative RMSE, sqrt(sum (a - b)^2 / sum b^2) over its pixels; that
// of a shard is the 90th percentile over its lights. The estimate comes from the tracer's two
// replicates (raytrace/streak_tracer.h), which do not see what both share: times a
// margin, and with shared_error besides, it must keep the error (docs/generator.md has the
// measurements behind both).
#pragma once

#include <functional>

#include "raytrace/streak_tracer.h"

namespace pluvia {

constexpr int accuracy_levels = 7;

// What both replicates share at the finest levels: no smaller error can be promised.
constexpr double shared_error = 0.003;

// The request with a level's settings of time and field, 0 (coarsest) .. accuracy_levels - 1.
// Slices follow the rows of the path and the periods of the drop.
StreakRequest at_accuracy_level(StreakRequest request, int level);

// Of so many values in order, the place of the 90th percentile: the nearest rank. count >= 1.
std::size_t rank_90(std::size_t count);

// 90th percentile over the lights of the estimated relative error (rank_90; dark lights,
// whose error has no meaning, left out). 0 without lights.
double estimated_error(const TracedStreak& streak);

struct AccurateStreak {
  TracedStreak streak = {};
  int level = 0;
};

// Throws std::invalid_argument for a relative_error of shared_error or less, std::runtime_error
// when the finest level does not keep it; what trace_streak throws.
AccurateStreak trace_streak_to(const StreakRequest& request, double relative_error,
                               const std::function<void(double)>& progress = {});

}  // namespace pluvia
