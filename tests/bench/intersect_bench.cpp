// One ray against one drop: time per ray.
#include "raytrace/wide_intersect.h"

#include "tests/bench/bench_samples.h"

namespace pluvia {
namespace {

// From a point that the camera sees, along the refracted ray, to the far side.
void intersect_inside(benchmark::State& state) {
  const Isa isa = static_cast<Isa>(state.range(0));
  const DropInstant drop = bench_drop(state.range(1));
  std::vector<DropRay> rays;
  for (const SurfacePoint& point : bench_points(drop)) {
    // Snell's law: the tangential part of the direction shrinks by the index.
    const double facing = point.normal.dot(bench_camera());
    const Eigen::Vector3d along = (facing * point.normal - bench_camera()) / 1.333;
    rays.push_back({point.position_m, along - std::sqrt(1 - along.squaredNorm()) * point.normal});
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(intersect_drop_of(drop, rays, RaySide::inside, isa));
  }
  state.SetLabel(isa_name(isa));
  report_time_per_item(state, rays.size());
}
BENCHMARK(intersect_inside)->Apply(isas_and_phases)->Unit(benchmark::kMillisecond);

// The points of the surface around the camera's direction: position, normal, hidden or not.
void surface_points(benchmark::State& state) {
  const Isa isa = static_cast<Isa>(state.range(0));
  const DropInstant drop = bench_drop(state.range(1));
  const auto directions = bench_directions();
  for (auto _ : state) {
    benchmark::DoNotOptimize(surface_points_of(drop, directions, bench_camera(), isa));
  }
  state.SetLabel(isa_name(isa));
  report_time_per_item(state, directions.size());
}
BENCHMARK(surface_points)->Apply(isas_and_phases)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pluvia
