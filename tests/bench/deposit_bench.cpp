// One triangle into the picture of a slice: time per triangle.
#include "raytrace/streak_frame.h"

#include <benchmark/benchmark.h>

#include "tests/bench/bench_samples.h"
#include "tests/drop_samples.h"

namespace pluvia {
namespace {

// Triangles of side `size` hundredths of a pixel within a drop 16 pixels across, over 1.5 rows.
void deposit_triangles(benchmark::State& state) {
  const double size = static_cast<double>(state.range(0)) / 100;
  Random random(1);
  const auto jitter = [&] { return uniform(random, -size / 2, size / 2); };
  std::vector<ConePolygon> polygons(1000);
  for (ConePolygon& polygon : polygons) {
    const double x = uniform(random, 8, 24), y = uniform(random, -8, 8);
    polygon.count = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      polygon.vertices[k] = {0, 0, 1, x + jitter(), y + jitter(), 0.5, 1, 1};
    }
  }
  StreakFrame frame;
  frame.height_px = 512;
  frame.pixel_m = 2e-4;
  StreakWindow window = make_window(frame, 1, 1.6e-3, 100, 101.5);
  for (auto _ : state) {
    for (const ConePolygon& polygon : polygons) deposit(window, 0, {100, 101.5}, polygon, 1);
    benchmark::DoNotOptimize(window.values.data());
  }
  report_time_per_item(state, polygons.size());
}
BENCHMARK(deposit_triangles)->ArgName("size")->Arg(10)->Arg(50)->Arg(200);

}  // namespace
}  // namespace pluvia
