#include "raytrace/streak_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>

#include "raytrace/light_integral.h"

namespace pluvia {

namespace {

constexpr int replicates = 2;
constexpr int slices_per_block = 12;  // fixed: blocks, not threads, decide the order of additions
constexpr int rigid_grids = 8;        // per replicate

struct Block {
  int replicate = 0;
  int first = 0, count = 0;  // slices
};

struct BlockResult {
  int replicate = 0;
  StreakWindow window = {};
  PathRemainder remainder = {};
  std::size_t traced_nodes = 0;
};

// Uniform in [0, 1) from three integers: the finaliser of SplitMix64 over their combination.
double uniform_hash(std::uint64_t seed, int replicate, int slice) {
  std::uint64_t x = seed * 0x9E3779B97F4A7C15u +
                    static_cast<std::uint64_t>(replicate) * 0xBF58476D1CE4E5B9u +
                    static_cast<std::uint64_t>(slice) * 0x94D049BB133111EBu + 0x632BE59BD9B4E019u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-53;
}

struct StreakJob {
  const StreakRequest& request;
  View view = {};
  ConeLights lights = {};
  bool rigid = false;
  int slices = 0;

  int planes() const { return static_cast<int>(lights.directions.size()) + 2; }

  Travel travel(int slice) const {
    const StreakFrame& frame = request.frame;
    if (rigid) return {frame.path_top_row, frame.path_top_row + frame.path_rows};
    return {frame.path_top_row + frame.path_rows * slice / slices,
            frame.path_top_row + frame.path_rows * (slice + 1) / slices};
  }

  BlockResult trace(const Block& block) const {
    BlockResult result;
    result.replicate = block.replicate;
    const double radius = request.drop.mean_radius_m * drop_bound();
    result.window = make_window(request.frame, planes(), radius, travel(block.first).first_row,
                                travel(block.first + block.count - 1).last_row);
    for (int s = block.first; s < block.first + block.count; ++s) trace_slice(s, result);
    return result;
  }

  // Largest radius over r0 at any time: the sum of all amplitudes, and the shift of the centroid.
  double drop_bound() const {
    DropShape widest = request.drop;
    for (Mode& mode : widest.modes) mode.phase_rad = std::numbers::pi / 2;
    const DropInstant instant = drop_at(widest, 0);
    return 1.1 * instant.bound_h + instant.origin_m.norm() / request.drop.mean_radius_m;
  }

  void trace_slice(int slice, BlockResult& result) const {
    const double share = (slice + (result.replicate == 0 ? 0.25 : 0.75)) / slices;
    const DropInstant drop = drop_at(request.drop, rigid ? 0 : share * request.exposure_s);
    FieldOptions options = request.field;
    const double u = uniform_hash(request.seed, result.replicate, 2 * slice);
    options.rotation_rad = 2 * std::numbers::pi * u;
    options.shift = uniform_hash(request.seed, result.replicate, 2 * slice + 1) - 0.5;
    const ExitField field = trace_exit_field(drop, view, lights, options);
    integrate_lights(field, lights, request.frame, travel(slice), 1.0 / slices, result.window);
    result.remainder.beyond_order += field.remainder.beyond_order;
    result.remainder.given_up += field.remainder.given_up;
    result.remainder.lost += field.remainder.lost;
    result.traced_nodes += field.traced_nodes;
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

std::vector<Block> make_blocks(int slices) {
  std::vector<Block> blocks;
  for (int r = 0; r < replicates; ++r) {
    for (int first = 0; first < slices; first += slices_per_block) {
      blocks.push_back({r, first, std::min(slices_per_block, slices - first)});
    }
  }
  return blocks;
}

}  // namespace

TracedStreak trace_streak(const StreakRequest& request,
                          const std::function<void(double)>& progress) {
  refuse_thin_drop(request);
  StreakJob job{request};
  job.view = view_from_elevation(request.view_elevation_deg);
  job.lights.half_angle_rad = request.cone_half_angle_rad;
  for (const LightDirection& l : request.lights) {
    job.lights.directions.push_back(light_direction(l.elevation_deg, l.azimuth_deg));
  }
  job.rigid = is_rigid(request.drop);
  job.slices = job.rigid ? rigid_grids : request.slices;

  Sums sums;
  sums.plane_size = static_cast<std::size_t>(request.frame.width_px) *
                    static_cast<std::size_t>(request.frame.height_px);
  for (auto& values : sums.values) {
    values.assign(sums.plane_size * static_cast<std::size_t>(job.planes()), 0.0);
  }
  TracedStreak streak;
  const std::vector<Block> blocks = make_blocks(job.slices);
  std::size_t next = 0, done = 0;
  const auto feed = [&](tbb::flow_control& control) {
    if (next == blocks.size()) {
      control.stop();
      return Block{};
    }
    return blocks[next++];
  };
  const auto collect = [&](BlockResult block) {
    add_window(sums, request.frame, block);
    streak.beyond_order += block.remainder.beyond_order;
    streak.lost += block.remainder.lost + block.remainder.given_up;
    streak.traced_nodes += block.traced_nodes;
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(blocks.size()));
  };
  tbb::parallel_pipeline(
      8, tbb::make_filter<void, Block>(tbb::filter_mode::serial_in_order, feed) &
             tbb::make_filter<Block, BlockResult>(tbb::filter_mode::parallel,
                                                  [&](const Block& b) { return job.trace(b); }) &
             tbb::make_filter<BlockResult, void>(tbb::filter_mode::serial_in_order, collect));
  if (streak.traced_nodes > 0) {
    streak.beyond_order /= static_cast<double>(streak.traced_nodes);
    streak.lost /= static_cast<double>(streak.traced_nodes);
  }
  const std::size_t light_count = request.lights.size();
  for (std::size_t k = 0; k < light_count; ++k) {
    streak.light.push_back(mean_and_variance(sums, k));
  }
  streak.env = mean_and_variance(sums, light_count);
  streak.coverage = mean_and_variance(sums, light_count + 1);
  return streak;
}

}  // namespace pluvia
