// The exit field of a span of time, and light from it: time, and how it grows with the field's
// settings, the lights and the moments. One axis at a time is varied about a middle setting.
#include "raytrace/exit_field.h"

#include "atlas/streak_database.h"
#include "raytrace/light_integral.h"
#include "tests/bench/bench_samples.h"

namespace pluvia {
namespace {

// The arguments, in this order.
struct FieldCase {
  std::int64_t cells = 12, space = 2, time = 1, order = 3, lights = 74, moments = 24;

  std::vector<std::int64_t> arguments() const {
    return {cells, space, time, order, lights, moments};
  }
};

FieldCase field_case(const benchmark::State& state) {
  return {state.range(0), state.range(1), state.range(2),
          state.range(3), state.range(4), state.range(5)};
}

void vary(benchmark::internal::Benchmark* bench, std::int64_t FieldCase::*axis,
          std::initializer_list<std::int64_t> values) {
  for (const std::int64_t value : values) {
    FieldCase setting;
    setting.*axis = value;
    bench->Args(setting.arguments());
  }
}

void name_axes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"cells", "space", "time", "order", "lights", "moments"});
  bench->Args(FieldCase().arguments())->Unit(benchmark::kMillisecond);
}

void field_axes(benchmark::internal::Benchmark* bench) {
  name_axes(bench);
  vary(bench, &FieldCase::cells, {6, 24});
  vary(bench, &FieldCase::space, {0, 1, 3});
  vary(bench, &FieldCase::time, {0, 2});
  vary(bench, &FieldCase::order, {0, 1, 2, 5});
  vary(bench, &FieldCase::lights, {1, 4, 16});
}

void light_axes(benchmark::internal::Benchmark* bench) {
  field_axes(bench);
  vary(bench, &FieldCase::moments, {6, 96});
}

// As many of the 74 directions of 2006, evenly spread over their list, as cones of 5 degrees.
ConeLights cones(std::int64_t count) {
  ConeLights lights;
  lights.half_angle_rad = 5 * std::numbers::pi / 180;
  const std::vector<LightDirection> all = gn2006_light_directions();
  for (std::int64_t k = 0; k < count; ++k) {
    const auto index = static_cast<std::size_t>(k) * all.size() / static_cast<std::size_t>(count);
    lights.directions.push_back(light_direction(all[index].elevation_deg, all[index].azimuth_deg));
  }
  return lights;
}

constexpr double spans_per_period = 12;  // the preset gn2006's

// The second of the fastest mode's period: the drop is neither a sphere nor at rest.
TimeSpan bench_span(const DropShape& drop) {
  const double length_s = 2 * std::numbers::pi / mode_frequency_rad_s(drop, 3) / spans_per_period;
  return {length_s, 2 * length_s};
}

ExitField bench_field(const FieldCase& setting) {
  FieldOptions options;
  options.base_cells = static_cast<int>(setting.cells);
  options.space_depth = static_cast<int>(setting.space);
  options.time_depth = static_cast<int>(setting.time);
  options.paths.max_order = static_cast<int>(setting.order);
  const DropShape drop = bench_shape();
  return trace_exit_field(drop, bench_span(drop), view_from_elevation(20), cones(setting.lights),
                          options);
}

void field(benchmark::State& state) {
  const FieldCase setting = field_case(state);
  std::size_t nodes = 0, patches = 0;
  for (auto _ : state) {
    const ExitField traced = bench_field(setting);
    nodes = traced.nodes.size();
    patches = traced.patches.size();
  }
  state.counters["nodes"] = static_cast<double>(nodes);
  state.counters["patches"] = static_cast<double>(patches);
  report_time_per_item(state, nodes);
}
BENCHMARK(field)->Apply(field_axes);

// `count` slices everywhere, of a drop that falls 1.2 rows in each.
SpanSlices bench_slices(std::int64_t count) {
  const auto most = static_cast<double>(count);
  return {.travel = {30, 30 + 1.2 * most}, .most = most, .motion_tolerance = 0};
}

void lights(benchmark::State& state) {
  const FieldCase setting = field_case(state);
  const ExitField traced = bench_field(setting);
  const ConeLights cone_lights = cones(setting.lights);
  const SpanSlices slices = bench_slices(setting.moments);
  const StreakFrame frame = {.width_px = 32,
                             .height_px = 256,
                             .pixel_m = 1.6e-3 / 11.2,
                             .centre_column = 16,
                             .path_top_row = 30,
                             .path_rows = 196};
  StreakWindow window = make_window(frame, static_cast<int>(setting.lights) + 2, 2e-3,
                                    slices.travel.first_row, slices.travel.last_row);
  for (auto _ : state) {
    integrate_lights(traced, cone_lights, frame, slices, window);
    benchmark::DoNotOptimize(window.values.data());
  }
  state.counters["patches"] = static_cast<double>(traced.patches.size());
  report_time_per_item(state, static_cast<std::size_t>(setting.moments));
}
BENCHMARK(lights)->Apply(light_axes);

}  // namespace
}  // namespace pluvia
