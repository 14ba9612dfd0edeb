// All exits, orders 0 to 3, of the points that a camera sees: time per point.
#include "raytrace/wide_paths.h"

#include "tests/bench/bench_samples.h"

namespace pluvia {
namespace {

void paths(benchmark::State& state) {
  const Isa isa = static_cast<Isa>(state.range(0));
  const DropInstant drop = bench_drop(state.range(1));
  std::vector<CameraHit> hits;
  for (const SurfacePoint& point : bench_points(drop)) {
    hits.push_back({point.position_m, point.normal});
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(trace_exits_of(drop, hits, bench_camera(), {}, isa));
  }
  state.SetLabel(isa_name(isa));
  report_time_per_item(state, hits.size());
}
BENCHMARK(paths)->Apply(isas_and_phases)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pluvia
