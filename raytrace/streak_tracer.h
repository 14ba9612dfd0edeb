// One shard: the streak of one oscillation seen from one direction, for all its lights at once.
//
// The exposure is cut into spans; over each the drop's exit field is traced (exit_field.h), and its
// light deposited in slices of time, as many as each path needs (light_integral.h), over the rows
// that the drop passes in them. The whole is done twice, as two replicates with differently turned
// and shifted grids and with slices that lie half a slice apart; the result is their mean, and ((a
// - b) / 2)^2 its variance: the noise of sampling time and grid. A bias that both share is not in
// it. A rigid drop needs no time: a few differently turned grids, each smeared over the whole path.
#pragma once

#include <cstdint>
#include <functional>

#include "atlas/streak_database.h"
#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"
#include "raytrace/surface_light.h"

namespace pluvia {

// Raised by every change that alters a shard's bytes: a database of another version is not resumed.
constexpr int tracer_version = 3;

// A drop whose surface comes nearer to its centre, over its mean radius, is refused: the two modes
// no longer describe water there.
constexpr double smallest_relative_radius = 0.2;

struct StreakRequest {
  DropShape drop = {};
  double view_elevation_deg = 0;
  std::vector<LightDirection> lights = {};
  // 1e-4 .. pi / 4, or 0: points at infinity, whose light comes in glints (raytrace/glints.h).
  double cone_half_angle_rad = 0.0873;
  double exposure_s = 1.0 / 60;
  StreakFrame frame = {};
  FieldOptions field = {};
  int slices = 1024;              // per replicate, at most
  double motion_tolerance = 0.5;  // of directions in a slice (SpanSlices)
  double spans_per_period = 12;   // of the fastest mode
  std::uint64_t seed = 1;         // of the grids' turns and shifts
  EnvironmentRequest environment = {};
};

// Periods of the drop's fastest mode in a time; 0 for a rigid drop.
double fastest_mode_periods(const DropShape& drop, double duration_s);

struct TracedStreak {
  std::vector<StreakImage> light = {};
  StreakImage env = {};  // uniform; empty where it was not asked for
  StreakImage coverage = {};
  // By harmonic_index: under an environment of radiance Y_lm, so negative values belong. Any
  // environment of coefficients c lights the streak by sum c_lm transfer_lm.
  std::vector<StreakImage> transfer = {};
  std::vector<StreakImage> mapped = {};  // under the request's map, one image for each channel
  double beyond_order = 0;  // mean over the traced rays of the power still inside after max_order
  double lost = 0;          // mean power of rays that could not be followed
  std::size_t traced_nodes = 0;
};

// Same bytes for any number of threads. `progress` gets the share done, 0 .. 1, from one thread at
// a time. Throws std::invalid_argument for a drop whose surface comes nearer than 0.2 r0 to its
// centre, an amplitude that is not finite, a cone out of its range, and a transfer_degree beyond
// highest_harmonic_degree.
TracedStreak trace_streak(const StreakRequest& request,
                          const std::function<void(double)>& progress = {});

}  // namespace pluvia
