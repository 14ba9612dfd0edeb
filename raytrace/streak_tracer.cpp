#include "raytrace/streak_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>

#include "raytrace/light_integral.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {

namespace {

constexpr int replicates = 2;
constexpr int rigid_grids = 8;  // per replicate

// A point light has no size that says how smooth a map is to be: 1 degree puts a glint to within
// bend_tolerance of that in direction, and the slope of the map, which is its light, to as much of
// a cell's change.
constexpr double glint_cone_rad = std::numbers::pi / 180;

constexpr double least_cone_rad = 1e-4;

// One span of one replicate: the unit of work, and of the order of additions.
struct Block {
  int replicate = 0;
  int span = 0;
};

struct BlockResult {
  int replicate = 0;
  StreakWindow window = {};
  PathRemainder remainder = {};
  std::size_t traced_nodes = 0;
};

// Uniform in [0, 1) from three integers: the finaliser of SplitMix64 over their combination.
double uniform_hash(std::uint64_t seed, int replicate, int draw) {
  std::uint64_t x = seed * 0x9E3779B97F4A7C15u +
                    static_cast<std::uint64_t>(replicate) * 0xBF58476D1CE4E5B9u +
                    static_cast<std::uint64_t>(draw) * 0x94D049BB133111EBu + 0x632BE59BD9B4E019u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-53;
}

struct StreakJob {
  const StreakRequest& request;
  tbb::enumerable_thread_specific<ExitField>& fields;  // each thread's last: memory for its next
  View view = {};
  ConeLights lights = {};
  bool rigid = false;
  int spans = 1;               // of a replicate
  double slices_per_span = 1;  // at most

  int planes() const {
    return static_cast<int>(lights.directions.size() + value_count(request.environment)) +
           (request.environment.uniform ? 2 : 1);
  }

  // The span of a block, in time and in rows.
  SpanSlices slices_of(const Block& block) const {
    const StreakFrame& frame = request.frame;
    const double share = 1.0 / spans;
    return {.travel = {frame.path_top_row + frame.path_rows * share * block.span,
                       frame.path_top_row + frame.path_rows * share * (block.span + 1)},
            .time_share = share,
            .most = slices_per_span,
            .motion_tolerance = request.motion_tolerance,
            .shifted = block.replicate == 1};
  }

  BlockResult trace(const Block& block) const {
    FieldOptions options = request.field;
    options.rotation_rad =
        2 * std::numbers::pi * uniform_hash(request.seed, block.replicate, 2 * block.span);
    options.shift = uniform_hash(request.seed, block.replicate, 2 * block.span + 1) - 0.5;
    BlockResult result;
    result.replicate = block.replicate;
    if (rigid) {
      const StreakFrame& frame = request.frame;
      add({0, 0}, options,
          {.travel = {frame.path_top_row, frame.path_top_row + frame.path_rows},
           .time_share = 1.0 / spans},
          result);
      return result;
    }
    const TimeSpan span = {request.exposure_s * block.span / spans,
                           request.exposure_s * (block.span + 1) / spans};
    add(span, options, slices_of(block), result);
    return result;
  }

  void add(const TimeSpan& span, const FieldOptions& options, const SpanSlices& slices,
           BlockResult& result) const {
    const double radius = request.drop.mean_radius_m * drop_bound();
    result.window = make_window(request.frame, planes(), radius, slices.travel.first_row,
                                slices.travel.last_row);
    ConeLights looking = lights;  // where the field is to be fine
    if (lights.half_angle_rad == 0) looking.half_angle_rad = glint_cone_rad;
    ExitField& field = fields.local();
    field = trace_exit_field(request.drop, span, view, looking, options, std::move(field));
    integrate_lights(field, lights, request.frame, slices, result.window, request.environment);
    result.remainder = field.remainder;
    result.traced_nodes = field.traced_nodes;
  }

  // Largest radius over r0 at any time: the sum of all amplitudes, and the shift of the centroid.
  double drop_bound() const {
    DropShape widest = request.drop;
    for (Mode& mode : widest.modes) mode.phase_rad = std::numbers::pi / 2;
    const DropInstant instant = drop_at(widest, 0);
    return 1.1 * instant.bound_h + instant.origin_m.norm() / request.drop.mean_radius_m;
  }
};

// Full pictures of both replicates.
struct Sums {
  std::vector<double> values[replicates];
  std::size_t plane_size = 0;
};

void add_window(Sums& sums, const StreakFrame& frame, BlockResult& block) {
  StreakWindow& window = block.window;
  for (int plane = 0; plane < window.planes; ++plane) {
    for (int r = 0; r < window.rows; ++r) {
      double* to =
          sums.values[block.replicate].data() + static_cast<std::size_t>(plane) * sums.plane_size +
          static_cast<std::size_t>(window.first_row + r) * static_cast<std::size_t>(frame.width_px);
      const double* from = window.row(plane, r);
      for (int c = 0; c < frame.width_px; ++c) to[c] += from[c];
    }
  }
}

StreakImage mean_and_variance(const Sums& sums, std::size_t plane) {
  StreakImage image;
  image.mean.reserve(sums.plane_size);
  image.variance.reserve(sums.plane_size);
  for (std::size_t i = 0; i < sums.plane_size; ++i) {
    const double a = sums.values[0][plane * sums.plane_size + i];
    const double b = sums.values[1][plane * sums.plane_size + i];
    image.mean.push_back(static_cast<float>(0.5 * (a + b)));
    image.variance.push_back(static_cast<float>(0.25 * (a - b) * (a - b)));
  }
  return image;
}

void take_images(const Sums& sums, const StreakRequest& request, TracedStreak& streak) {
  std::size_t plane = 0;
  const auto take = [&] { return mean_and_variance(sums, plane++); };
  for (std::size_t k = 0; k < request.lights.size(); ++k) streak.light.push_back(take());
  if (request.environment.uniform) streak.env = take();
  streak.coverage = take();
  const std::size_t harmonics = transfer_count(request.environment);
  const std::size_t channels = map_count(request.environment);
  while (streak.transfer.size() < harmonics) streak.transfer.push_back(take());
  while (streak.mapped.size() < channels) streak.mapped.push_back(take());
}

void refuse_wrong_environment(const EnvironmentRequest& environment) {
  if (environment.transfer_degree < -1 || environment.transfer_degree > highest_harmonic_degree) {
    throw std::invalid_argument(
        fmt::format("transfer_degree = {}; expected 0 .. {}, or -1 for none",
                    environment.transfer_degree, highest_harmonic_degree));
  }
  const Image& map = environment.map.radiance;
  if (!map.values.empty() && map.width != 2 * map.height) {
    throw std::invalid_argument(
        fmt::format("an environment map of {} x {} pixels; expected width = 2 * height", map.width,
                    map.height));
  }
}

void refuse_thin_drop(const StreakRequest& request) {
  for (const Mode& mode : request.drop.modes) {
    if (std::isfinite(mode.amplitude)) continue;
    throw std::invalid_argument(fmt::format("amplitude {} of mode {}, {}; expected a finite number",
                                            mode.amplitude, mode.n, mode.m));
  }
  const double smallest = minimum_relative_radius(request.drop, request.exposure_s);
  if (smallest <= smallest_relative_radius) {
    throw std::invalid_argument(fmt::format(
        "the drop's surface comes as near as {:.3f} r0 to its centre; expected more than {} r0 "
        "(smaller amplitudes)",
        smallest, smallest_relative_radius));
  }
}

void refuse_cone(double half_angle_rad) {
  if (half_angle_rad == 0) return;
  if (half_angle_rad >= least_cone_rad && half_angle_rad < std::numbers::pi / 4) return;
  throw std::invalid_argument(fmt::format("cone_half_angle_rad = {}; expected 0, or {} .. pi / 4",
                                          half_angle_rad, least_cone_rad));
}

std::vector<Block> make_blocks(int spans) {
  std::vector<Block> blocks;
  for (int r = 0; r < replicates; ++r) {
    for (int span = 0; span < spans; ++span) blocks.push_back({r, span});
  }
  return blocks;
}

StreakJob make_job(const StreakRequest& request,
                   tbb::enumerable_thread_specific<ExitField>& fields) {
  StreakJob job{.request = request, .fields = fields};
  job.view = view_from_elevation(request.view_elevation_deg);
  job.lights.half_angle_rad = request.cone_half_angle_rad;
  for (const LightDirection& l : request.lights) {
    job.lights.directions.push_back(light_direction(l.elevation_deg, l.azimuth_deg));
  }
  job.rigid = is_rigid(request.drop);
  if (job.rigid) {
    job.spans = rigid_grids;
    return job;
  }
  const double periods = fastest_mode_periods(request.drop, request.exposure_s);
  job.spans = std::max(1, static_cast<int>(std::ceil(periods * request.spans_per_period)));
  job.slices_per_span = std::max(1.0, static_cast<double>(request.slices) / job.spans);
  return job;
}

}  // namespace

double fastest_mode_periods(const DropShape& drop, double duration_s) {
  double fastest_rad_s = 0;
  for (const Mode& mode : drop.modes) {
    if (mode.amplitude == 0) continue;
    fastest_rad_s = std::max(fastest_rad_s, mode_frequency_rad_s(drop, mode.n));
  }
  return fastest_rad_s * duration_s / (2 * std::numbers::pi);
}

TracedStreak trace_streak(const StreakRequest& request,
                          const std::function<void(double)>& progress) {
  refuse_thin_drop(request);
  refuse_cone(request.cone_half_angle_rad);
  refuse_wrong_environment(request.environment);
  tbb::enumerable_thread_specific<ExitField> fields;
  const StreakJob job = make_job(request, fields);
  Sums sums;
  sums.plane_size = static_cast<std::size_t>(request.frame.width_px) *
                    static_cast<std::size_t>(request.frame.height_px);
  for (auto& values : sums.values) {
    values.assign(sums.plane_size * static_cast<std::size_t>(job.planes()), 0.0);
  }
  TracedStreak streak;
  const std::vector<Block> blocks = make_blocks(job.spans);
  std::size_t next = 0, done = 0;
  const auto feed = [&](tbb::flow_control& control) -> std::size_t {
    if (next == blocks.size()) {
      control.stop();
      return 0;
    }
    return next++;
  };
  const auto collect = [&](BlockResult block) {
    add_window(sums, request.frame, block);
    streak.beyond_order += block.remainder.beyond_order;
    streak.lost += block.remainder.lost + block.remainder.given_up;
    streak.traced_nodes += block.traced_nodes;
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(blocks.size()));
  };
  tbb::parallel_pipeline(
      8, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, feed) &
             tbb::make_filter<std::size_t, BlockResult>(
                 tbb::filter_mode::parallel,
                 [&](std::size_t index) { return job.trace(blocks[index]); }) &
             tbb::make_filter<BlockResult, void>(tbb::filter_mode::serial_in_order, collect));
  if (streak.traced_nodes > 0) {
    streak.beyond_order /= static_cast<double>(streak.traced_nodes);
    streak.lost /= static_cast<double>(streak.traced_nodes);
  }
  take_images(sums, request, streak);
  return streak;
}

}  // namespace pluvia
