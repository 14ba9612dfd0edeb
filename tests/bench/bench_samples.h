// What the benchmarks work on: the oscillating drop of docs/generator.md, at some of its phases.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Geometry>

#include "oscillation/drop_shape.h"
#include "raytrace/wide_intersect.h"

namespace pluvia {

// (A20, A31) = (0.11, 0.1), r0 = 1.6 mm.
inline DropShape bench_shape() {
  DropShape drop;
  drop.mean_radius_m = 1.6e-3;
  drop.modes = {{.n = 2, .m = 0, .amplitude = 0.11}, {.n = 3, .m = 1, .amplitude = 0.1}};
  return drop;
}

// At 0 .. 3 quarters of the slower mode's period.
inline DropInstant bench_drop(std::int64_t quarter) {
  const DropShape drop = bench_shape();
  const double period_s = 2 * std::numbers::pi / mode_frequency_rad_s(drop, 2);
  return drop_at(drop, static_cast<double>(quarter) / 4 * period_s);
}

// From 20 degrees above the horizon.
inline Eigen::Vector3d bench_camera() {
  return {std::cos(std::numbers::pi / 9), 0, std::sin(std::numbers::pi / 9)};
}

// A lattice of about 5,000 directions around the camera's.
inline std::vector<Eigen::Vector3d> bench_directions() {
  constexpr int half = 40;
  const Eigen::Vector3d axis = bench_camera(), e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  std::vector<Eigen::Vector3d> directions;
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i) {
      const Eigen::Vector2d at = Eigen::Vector2d(i, j) * (1.7 / half);
      const double angle = at.norm();
      const double sinc = angle > 1e-9 ? std::sin(angle) / angle : 1;
      if (angle > 1.7) continue;
      directions.push_back(std::cos(angle) * axis + sinc * (at.x() * e1 + at.y() * e2));
    }
  }
  return directions;
}

// The lattice's points that the camera sees.
inline std::vector<SurfacePoint> bench_points(const DropInstant& drop) {
  auto points = surface_points_of(drop, bench_directions(), bench_camera(), Isa::scalar);
  std::erase_if(points, [](const SurfacePoint& point) {
    return point.hidden || point.normal.dot(bench_camera()) <= 0;
  });
  return points;
}

// "every set that the processor has" x "four phases".
inline void isas_and_phases(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"isa", "quarter"});
  for (const Isa isa : {Isa::scalar, Isa::avx2, Isa::avx512}) {
    if (!cpu_has(isa)) continue;
    for (std::int64_t quarter = 0; quarter < 4; ++quarter) {
      bench->Args({static_cast<std::int64_t>(isa), quarter});
    }
  }
}

// Reports CPU time for each of `items` done in every iteration.
inline void report_time_per_item(benchmark::State& state, std::size_t items) {
  state.counters["s_per_item"] =
      benchmark::Counter(static_cast<double>(items), benchmark::Counter::kIsIterationInvariantRate |
                                                         benchmark::Counter::kInvert);
}

}  // namespace pluvia
