#include "raytrace/streak_frame.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

StreakWindow empty_window(int rows, int width, int first_row = 0) {
  StreakWindow window;
  window.first_row = first_row;
  window.rows = rows;
  window.width_px = width;
  window.planes = 1;
  window.values.assign(static_cast<std::size_t>(rows * width), 0.0);
  return window;
}

ConePolygon triangle(double x0, double y0, double x1, double y1, double x2, double y2,
                     double throughput = 1) {
  ConePolygon polygon;
  polygon.count = 3;
  polygon.vertices[0] = {0, 0, 1, x0, y0, throughput, 1, 1};
  polygon.vertices[1] = {0, 0, 1, x1, y1, throughput, 1, 1};
  polygon.vertices[2] = {0, 0, 1, x2, y2, throughput, 1, 1};
  return polygon;
}

double sum_of(const StreakWindow& window) {
  return std::accumulate(window.values.begin(), window.values.end(), 0.0);
}

TEST(StreakFrame, ADepositKeepsItsAmountForAnyTravelAndSize) {
  // Second differences of squares of up to 500 rows over widths down to 0.01 row: 1e-16 500^2 /
  // (0.01 travel) < 3e-11 of the amount.
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    const double size = std::pow(10, uniform(random, -7, 1));
    const double travel = std::pow(10, uniform(random, -7, 2.5));
    const double x = uniform(random, 12, 20), y = uniform(random, -10, 10);
    const auto jitter = [&] { return uniform(random, -size, size); };
    const ConePolygon polygon = triangle(x + jitter(), y + jitter(), x + jitter(), y + jitter(),
                                         x + jitter(), y + jitter(), 0.3);
    StreakWindow window = empty_window(450, 32);
    deposit(window, 0, {50, 50 + travel}, polygon, 2);
    const double expected = 2 * 0.3 * polygon_flux(polygon).area;
    ASSERT_NEAR(sum_of(window), expected, 1e-10 * expected) << "size " << size << ", " << travel;
    for (const double value : window.values) ASSERT_GE(value, -1e-10 * expected);
  }
}

TEST(StreakFrame, PolygonsExactlyOnPixelEdgesFillExactlyTheirPixels) {
  // A unit square on pixel (3, 10 + 4), standing still: two triangles of half a pixel each.
  StreakWindow window = empty_window(20, 8);
  for (const auto& half : {triangle(3, 4, 4, 4, 4, 5), triangle(3, 4, 4, 5, 3, 5)}) {
    deposit(window, 0, {10, 10}, half, 1);
  }
  // Standing still is a travel of 0.01 row: half of that leaks over each edge on average a quarter.
  EXPECT_NEAR(window.row(0, 14)[3], 1, 0.0026);
  EXPECT_NEAR(sum_of(window), 1, 1e-12);
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 8; ++column) {
      if (column == 3) continue;
      EXPECT_EQ(window.row(0, row)[column], 0) << row << " " << column;
    }
  }
}

TEST(StreakFrame, ALongTravelSmearsEvenly) {
  // A small polygon over 100 rows: each row in the middle gets a hundredth.
  StreakWindow window = empty_window(200, 8);
  deposit(window, 0, {20.5, 120.5}, triangle(2, 0, 3, 0, 2, 1), 1);
  for (int row = 22; row < 120; ++row) EXPECT_NEAR(window.row(0, row)[2], 0.005, 1e-12) << row;
  EXPECT_NEAR(sum_of(window), 0.5, 1e-12);
}

TEST(StreakFrame, RowsGetTheTrapezoidOfPolygonAndTravel) {
  // Extents of 2 and travel of 3 rows, both uniform: the sum's density rises over [10, 12], stays
  // 1/3 to 13, falls to 15. Rows: 1/12, 3/12, 4/12, 3/12, 1/12.
  StreakWindow window = empty_window(30, 8);
  deposit(window, 0, {10, 13}, triangle(2, 0, 3, 0, 2, 2), 12);  // area 1
  const double expected[] = {0, 1, 3, 4, 3, 1, 0};
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(window.row(0, 9 + k)[2], expected[k], 1e-11) << k;
}

TEST(StreakFrame, ColumnsGetTheirOwnArea) {
  // A right triangle over columns 1..5 with height falling from 4 to 0: areas 3.5, 2.5, 1.5, 0.5.
  StreakWindow window = empty_window(40, 8);
  deposit(window, 0, {10, 20}, triangle(1, 0, 5, 0, 1, 4), 1);
  const double expected[] = {0, 3.5, 2.5, 1.5, 0.5, 0, 0, 0};
  for (int column = 0; column < 8; ++column) {
    double sum = 0;
    for (int row = 0; row < 40; ++row) sum += window.row(0, row)[column];
    EXPECT_NEAR(sum, expected[column], 1e-11) << column;
  }
}

TEST(StreakFrame, TheFrameCutsWhatIsBeyondItsEdges) {
  // The same triangle over columns -2..2 and rows above the first: 1.5 + 0.5 of 8 in columns 0
  // and 1.
  StreakWindow window = empty_window(60, 8);
  deposit(window, 0, {20, 30}, triangle(-2, 0, 2, 0, -2, 4), 1);
  EXPECT_NEAR(sum_of(window), 2, 1e-11);
  // Travel over [-50, 50] of a polygon of no height to speak of: half of it is in the window.
  StreakWindow half = empty_window(60, 8);
  deposit(half, 0, {-50, 50}, triangle(2, -0.005, 4, 0.005, 2, 0.005), 1);
  EXPECT_NEAR(sum_of(half), 0.005, 1e-6);
  StreakWindow none = empty_window(60, 8);
  deposit(none, 0, {20, 30}, triangle(-3, 0, -1, 0, -1, 4), 1);
  deposit(none, 0, {20, 30}, triangle(9, 0, 12, 0, 9, 4), 1);
  deposit(none, 0, {100, 130}, triangle(2, 0, 3, 0, 2, 4), 1);
  EXPECT_EQ(sum_of(none), 0);
}

TEST(StreakFrame, AWindowHoldsAllThatADropOfItsRadiusLeaves) {
  StreakFrame frame;
  frame.height_px = 500;
  frame.pixel_m = 1e-4;
  const StreakWindow window = make_window(frame, 3, 1e-3, 100, 140);
  EXPECT_EQ(window.first_row, 89);                 // 100 - 10 - 1
  EXPECT_EQ(window.first_row + window.rows, 151);  // 140 + 10 + 1
  EXPECT_EQ(window.values.size(), 3u * 62u * 32u);
  const StreakWindow top = make_window(frame, 1, 1e-3, 2, 6);
  EXPECT_EQ(top.first_row, 0);
  const StreakWindow bottom = make_window(frame, 1, 1e-3, 495, 499);
  EXPECT_EQ(bottom.first_row + bottom.rows, 500);
  EXPECT_EQ(make_window(frame, 1, 1e-3, 600, 620).rows, 0);
  // The first half of a deposit lands above an offset window's rows, the second in it.
  StreakWindow offset = empty_window(50, 8, 100);
  deposit(offset, 0, {90, 110}, triangle(2, -0.005, 3, -0.005, 2, 0.005), 1);
  EXPECT_NEAR(sum_of(offset), 0.0025, 1e-6);
  EXPECT_GT(offset.row(0, 5)[2], 0);
}

}  // namespace
}  // namespace pluvia
