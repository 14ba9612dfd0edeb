// How a span of time is cut into slices (raytrace/light_integral.h, light_integrator.h).
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "raytrace/light_integrator.h"

namespace pluvia {
namespace {

constexpr double degree = std::numbers::pi / 180;

struct Cut {
  ExitField field = {};
  StreakFrame frame = {.width_px = 16, .height_px = 64, .pixel_m = 0.25e-3};
  StreakWindow window = {};
  SpanSlices span = {.travel = {10, 30}, .time_share = 0.2, .most = 100};

  std::vector<Slice> slices(const FieldCell& cell, const Motion& motion, double importance) const {
    StreakWindow unused = window;
    const Integrator integrator{.field = field,
                                .frame = frame,
                                .span = span,
                                .window = unused,
                                .slice_direction = span.motion_tolerance * degree};
    return integrator.slices(cell, motion, importance);
  }
};

TEST(LightSlices, CoverTheCellsTimeWithoutGapOrOverlap) {
  Cut cut;
  FieldCell cell;
  cell.first = 0.25;
  cell.last = 0.75;
  for (const bool shifted : {false, true}) {
    cut.span.shifted = shifted;
    for (const double motion : {0.0, 0.01, 0.1, 100.0}) {
      const auto slices = cut.slices(cell, {.direction = motion}, 1);
      double row = 20 - 5, time = 0;  // a quarter of 20 rows into the span
      for (const Slice& slice : slices) {
        EXPECT_NEAR(slice.travel.first_row, row, 1e-12);
        EXPECT_GT(slice.travel.last_row, row);
        // Rows and time go together, and the moment stands in the slice's middle.
        EXPECT_NEAR(slice.time_share, 0.2 * (slice.travel.last_row - row) / 20, 1e-12);
        EXPECT_NEAR(10 + 20 * slice.span_share, 0.5 * (row + slice.travel.last_row), 1e-12);
        EXPECT_NEAR(slice.span_share, 0.25 + 0.5 * slice.cell_share, 1e-12);
        row = slice.travel.last_row;
        time += slice.time_share;
      }
      EXPECT_NEAR(row, 25, 1e-12);
      EXPECT_NEAR(time, 0.1, 1e-12);
    }
  }
}

TEST(LightSlices, AreAsManyAsTheMotionAsksForAndAtMostTheSpansShare) {
  Cut cut;
  const FieldCell cell;
  const double step = cut.span.motion_tolerance * degree;
  EXPECT_EQ(cut.slices(cell, {}, 1).size(), 1u);
  EXPECT_EQ(cut.slices(cell, {.direction = 6.5 * step}, 1).size(), 7u);
  EXPECT_EQ(cut.slices(cell, {.direction = 6.5 * step}, 0.1).size(), 1u);  // a tenth as important
  EXPECT_EQ(cut.slices(cell, {.picture_px = 2.2}, 1).size(), 5u);          // half a pixel each
  EXPECT_EQ(cut.slices(cell, {.direction = 1e9}, 1).size(), 100u);
  FieldCell half;
  half.last = 0.5;
  EXPECT_EQ(cut.slices(half, {.direction = 1e9}, 1).size(), 50u);
  cut.span.shifted = true;
  EXPECT_EQ(cut.slices(cell, {.direction = 6.5 * step}, 1).size(), 8u);  // two of them halves
  cut.span.motion_tolerance = 0;
  EXPECT_EQ(cut.slices(cell, {}, 1).size(), 101u);
}

// Sums of all planes of a span of an oscillating drop.
std::vector<double> sums(const SpanSlices& slices) {
  DropShape drop;
  drop.mean_radius_m = 1e-3;
  drop.modes = {{.n = 2, .amplitude = 0.11}, {.n = 3, .m = 1, .amplitude = 0.1}};
  ConeLights lights{.half_angle_rad = 3 * degree};
  lights.directions = {{-1, 0, 0}, Eigen::Vector3d(-1, 1, 0.5).normalized(), {0.8, 0, 0.6}};
  StreakFrame frame = {.width_px = 16, .height_px = 64, .pixel_m = 0.25e-3};
  frame.centre_column = 8;
  const View view = view_from_elevation(20);
  FieldOptions options;
  options.time_depth = 1;
  const ExitField field = trace_exit_field(drop, {0.8e-3, 1.1e-3}, view, lights, options);
  StreakWindow window =
      make_window(frame, 5, 1.6e-3, slices.travel.first_row, slices.travel.last_row);
  integrate_lights(field, lights, frame, slices, window);
  std::vector<double> planes;
  for (int plane = 0; plane < window.planes; ++plane) {
    const double* first = window.row(plane, 0);
    planes.push_back(std::accumulate(first, first + window.rows * window.width_px, 0.0));
  }
  return planes;
}

TEST(LightSlices, FewerSlicesHoldTheSameLight) {
  // A light's flux is smooth in time where no caustic sweeps over it: the midpoint rule with the
  // few slices that a motion of half the cone asks for gives what 400 give, to 1 %; the surface's
  // environment and coverage to 1e-3.
  const std::vector<double> truth =
      sums({.travel = {20, 36}, .time_share = 0.3, .most = 400, .motion_tolerance = 0});
  for (const bool shifted : {false, true}) {
    const std::vector<double> few =
        sums({.travel = {20, 36}, .time_share = 0.3, .most = 400, .shifted = shifted});
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_GT(truth[k], 0);
      EXPECT_NEAR(few[k] / truth[k], 1, k < 3 ? 1e-2 : 1e-3) << "plane " << k;
    }
  }
}

}  // namespace
}  // namespace pluvia
