#include "raytrace/drop_silhouette.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "raytrace/streak_tracer.h"

namespace pluvia {
namespace {

constexpr double radius_m = 1.6e-3;

DropShape wobbly_drop() {
  return {.mean_radius_m = radius_m,
          .modes = {{.n = 2, .m = 0, .amplitude = 0.19}, {.n = 3, .m = 1, .amplitude = 0.095}},
          .phi_drop_rad = 1.0};
}

// 16 columns, the drop's radius 5.6 px, a path of 40 rows.
StreakFrame small_frame() {
  return {.width_px = 16,
          .height_px = 60,
          .pixel_m = radius_m / 5.6,
          .centre_column = 8,
          .path_top_row = 9,
          .path_rows = 40};
}

// Whether some point of the line of sight through the image point lies inside the drop.
bool hits(const DropInstant& drop, const View& view, const Eigen::Vector2d& image_m) {
  for (double depth = -2; depth <= 2; depth += 0.001) {
    const Eigen::Vector3d p =
        image_m.x() * view.right + image_m.y() * view.up + depth * radius_m * view.to_camera;
    if (p.norm() <= surface_radius_m(drop, Eigen::Vector3d(p.normalized()))) return true;
  }
  return false;
}

TEST(DropSilhouette, OutlineSeparatesLinesThatHitTheDropFromThoseThatMiss) {
  const DropShape shape = wobbly_drop();
  for (const double time_s : {0.002, 0.007, 0.0125}) {
    for (const double elevation_deg : {0.0, 40.0, 80.0}) {
      const DropInstant drop = drop_at(shape, time_s);
      const View view = view_from_elevation(elevation_deg);
      // 4096 corners: the polygon is widened by 4e-7 only. The parabola is off by 1e-5 at most
      // where the drop is concave, the steps in depth hide points within (0.0005 r0)^2 / (2 r0) of
      // it.
      const auto outline = drop_outline_m(drop, view, 4096);
      for (std::size_t i = 0; i < outline.size(); i += 97) {
        EXPECT_TRUE(hits(drop, view, 0.9999 * outline[i])) << time_s << " s, corner " << i;
        EXPECT_FALSE(hits(drop, view, 1.0001 * outline[i])) << time_s << " s, corner " << i;
      }
    }
  }
}

TEST(DropSilhouette, SphereCoversItsDiscOverItsPath) {
  const StreakFrame frame = small_frame();
  const auto coverage = silhouette_coverage({.mean_radius_m = radius_m}, 0, 1.0 / 60, frame);
  // All of the drop stays in the picture, all of the time: sum = disc in pixels. 8 lines a column
  // take the disc's area as a midpoint rule does, off by 0.2 (h / r)^1.5 = 6e-4 with h = 1/8.
  const double sum = std::accumulate(coverage.begin(), coverage.end(), 0.0);
  EXPECT_NEAR(sum / (std::numbers::pi * 5.6 * 5.6), 1, 1e-3);
  // In the middle of the path a pixel is covered while its column's chord passes: 2 sqrt(r^2 - x^2)
  // rows of 40, with x up to 1 in the middle columns; mean over [0, 1].
  const double r = 5.6;
  const double chord = std::sqrt(r * r - 1) + r * r * std::asin(1 / r);
  EXPECT_NEAR(coverage[29 * 16 + 8], chord / 40, 1e-4);
  EXPECT_EQ(*std::max_element(coverage.begin(), coverage.begin() + 3 * 16), 0);  // above the drop
}

TEST(DropSilhouette, WhatFallsBeyondTheFrameIsCutOff) {
  StreakFrame frame = small_frame();
  const auto whole = silhouette_coverage(wobbly_drop(), 20, 1.0 / 60, frame);
  frame.height_px = 25;
  const auto cut = silhouette_coverage(wobbly_drop(), 20, 1.0 / 60, frame);
  ASSERT_EQ(cut.size(), 25u * 16);
  EXPECT_TRUE(std::equal(cut.begin(), cut.end(), whole.begin()));
}

TEST(DropSilhouette, AgreesWithTheCoverageThatRaysFind) {
  StreakRequest request;
  request.drop = wobbly_drop();
  request.view_elevation_deg = 40;
  request.frame = small_frame();
  request.slices = 40;
  const TracedStreak traced = trace_streak(request);
  const auto ours = silhouette_coverage(request.drop, 40, request.exposure_s, request.frame);
  double squares = 0, errors = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    errors += std::pow(ours[i] - traced.coverage.mean[i], 2);
    squares += std::pow(ours[i], 2);
  }
  // One slice a row and a field of 16 x 16 cells: the traced outline is off by about 1 % of the
  // radius in places, and a wrong sign or shift by one pixel costs more than 10 %.
  EXPECT_LT(std::sqrt(errors / squares), 0.02);
}

}  // namespace
}  // namespace pluvia
