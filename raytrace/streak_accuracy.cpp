#include "raytrace/streak_accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

struct Level {
  double usual_error;  // of the drops of gn2006 under lights of 1 to 5 degrees, 90th percentile
  double slices_per_row;
  double spans_per_period;
  int base_cells, space_depth, time_depth;
  double bend_tolerance, motion_tolerance;
};

constexpr std::array<Level, accuracy_levels> ladder = {{
    {0.30, 0.5, 8, 8, 1, 0, 1.0, 2.0},
    {0.12, 1, 10, 10, 2, 1, 0.6, 1.0},
    {0.06, 2, 10, 10, 3, 2, 0.6, 0.5},
    {0.03, 2, 10, 10, 3, 3, 0.6, 0.25},
    {0.02, 4, 12, 12, 4, 3, 0.4, 0.15},
    {0.012, 8, 14, 14, 4, 4, 0.3, 0.1},
    {0.008, 16, 16, 16, 5, 4, 0.2, 0.05},
}};

// The true error of a shard was at most this many times its estimate (docs/generator.md).
constexpr double margin = 1.5;

constexpr double slices_per_span = 4;  // at least

}  // namespace

StreakRequest at_accuracy_level(StreakRequest request, int level) {
  const Level& l = ladder.at(static_cast<std::size_t>(level));
  request.spans_per_period = l.spans_per_period;
  request.field.base_cells = l.base_cells;
  request.field.space_depth = l.space_depth;
  request.field.time_depth = l.time_depth;
  request.field.bend_tolerance = l.bend_tolerance;
  request.motion_tolerance = l.motion_tolerance;
  const double spans = fastest_mode_periods(request.drop, request.exposure_s) * l.spans_per_period;
  const double slices =
      std::max(l.slices_per_row * request.frame.path_rows, slices_per_span * spans);
  request.slices = std::max(4, static_cast<int>(std::ceil(slices)));
  return request;
}

std::size_t rank_90(std::size_t count) {
  return (9 * count + 9) / 10 - 1;
}

double estimated_error(const TracedStreak& streak) {
  std::vector<double> errors;
  for (const StreakImage& image : streak.light) {
    const bool dark =
        std::all_of(image.mean.begin(), image.mean.end(), [](float value) { return value == 0; });
    if (!dark) errors.push_back(estimated_relative_error(image));
  }
  if (errors.empty()) return 0;
  const std::size_t rank = rank_90(errors.size());
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank),
                   errors.end());
  return errors[rank];
}

AccurateStreak trace_streak_to(const StreakRequest& request, double relative_error,
                               const std::function<void(double)>& progress) {
  if (!(relative_error > shared_error)) {
    throw std::invalid_argument(
        fmt::format("relative error {}; expected more than {}", relative_error, shared_error));
  }
  int level = 0;
  while (level + 1 < accuracy_levels &&
         ladder[static_cast<std::size_t>(level)].usual_error > relative_error) {
    ++level;
  }
  for (;; ++level) {
    AccurateStreak result = {trace_streak(at_accuracy_level(request, level), progress), level};
    const double estimate = std::hypot(margin * estimated_error(result.streak), shared_error);
    if (estimate <= relative_error) return result;
    if (level + 1 == accuracy_levels) {
      throw std::runtime_error(
          fmt::format("estimated relative error {:.4f} at the finest setting; expected at most {}",
                      estimate, relative_error));
    }
  }
}

}  // namespace pluvia
