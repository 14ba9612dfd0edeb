#include "validate/streak_footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "raytrace/streak_placement.h"

namespace pluvia {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

StreakPicture picture_of(int width, int height, double top_row, double path_rows) {
  StreakPicture picture{width, height, top_row, path_rows, {}};
  for (int i = 0; i < width * height; ++i) {
    const double v = 1 + std::sin(1.7 * i) * 0.5;
    picture.values.push_back({v, 2 * v, 0, 0.3});
  }
  return picture;
}

StreakPlacement placed(Eigen::Vector2d origin, Eigen::Vector2d column, Eigen::Vector2d row,
                       double path_rows) {
  return {.origin_px = origin,
          .column_px = column,
          .row_px = row,
          .path_rows = path_rows,
          .clip_row = infinity};
}

Footprint laid_down(const StreakPlacement& placement, const StreakPicture& picture, int width = 40,
                    int height = 40) {
  Footprint footprint = empty_footprint(placement, {picture}, width, height);
  add_streak(placement, picture, footprint);
  return footprint;
}

StreakValue pixel(const Footprint& footprint, int x, int y) {
  const int i = x - footprint.x0, j = y - footprint.y0;
  if (i < 0 || j < 0 || i >= footprint.width || j >= footprint.height) return StreakValue::Zero();
  return footprint.values[static_cast<std::size_t>(j * footprint.width + i)];
}

TEST(StreakFootprint, APictureAlignedWithThePixelsIsCopied) {
  const StreakPicture picture = picture_of(3, 5, 1, 3);
  const Footprint footprint = laid_down(placed({7, 4}, {1, 0}, {0, 1}, 3), picture);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) {
      const bool inside = x >= 7 && x < 10 && y >= 4 && y < 9;
      const StreakValue expected =
          inside ? picture.values[static_cast<std::size_t>((y - 4) * 3 + x - 7)]
                 : StreakValue::Zero();
      // Rows pass through the stretch of the path and back: a few units in the last place.
      EXPECT_LT((pixel(footprint, x, y) - expected).norm(), 1e-14) << x << ", " << y;
    }
  }
}

TEST(StreakFootprint, HalfAPixelToTheRightAveragesNeighbours) {
  const StreakPicture picture = picture_of(3, 5, 1, 3);
  const Footprint footprint = laid_down(placed({7.5, 4}, {1, 0}, {0, 1}, 3), picture);
  for (int y = 4; y < 9; ++y) {
    const auto value = [&](int u) -> StreakValue {
      if (u < 0 || u > 2) return StreakValue::Zero();
      return picture.values[static_cast<std::size_t>((y - 4) * 3 + u)];
    };
    for (int x = 6; x < 12; ++x) {
      const StreakValue expected = (value(x - 8) + value(x - 7)) / 2;
      EXPECT_LT((pixel(footprint, x, y) - expected).norm(), 1e-14) << x << ", " << y;
    }
  }
}

// The other road to a pixel: many points in it, each taken back to (u, r), and the value there
// times the stretch of the row, which is the slope of cell_row.
StreakValue sampled_pixel(const StreakPlacement& placement, const StreakPicture& picture, int x,
                          int y, int steps) {
  Eigen::Matrix2d to_screen;
  to_screen << placement.column_px, placement.row_px;
  const Eigen::Matrix2d to_picture = to_screen.inverse();
  const auto cell = [&](double r) {
    return cell_row(r, picture.path_top_row, placement.path_rows, picture.path_rows);
  };
  StreakValue sum = StreakValue::Zero();
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) {
      const Eigen::Vector2d point(x + (i + 0.5) / steps, y + (j + 0.5) / steps);
      const Eigen::Vector2d at = to_picture * (point - placement.origin_px);
      const double row = cell(at.y());
      const int u = static_cast<int>(std::floor(at.x())), v = static_cast<int>(std::floor(row));
      if (u < 0 || u >= picture.width || v < 0 || v >= picture.height) continue;
      if (at.y() > placement.clip_row) continue;
      const double slope = (cell(at.y() + 1e-6) - cell(at.y() - 1e-6)) / 2e-6;
      sum += slope * picture.values[static_cast<std::size_t>(v * picture.width + u)];
    }
  }
  return sum / (steps * steps);
}

TEST(StreakFootprint, ASlantedStretchedAndCutStreakAgreesWithSampling) {
  const StreakPicture picture = picture_of(4, 30, 3.3, 22.2);
  for (const double scale : {2.3, 0.4, 0.05}) {
    for (const double clip_row : {infinity, 14.7}) {
      const double angle = 0.35;
      StreakPlacement placement =
          placed({12.3, 3.7}, scale * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                 0.6 * scale * Eigen::Vector2d(-std::sin(angle), std::cos(angle)), 26.1);
      placement.clip_row = clip_row;
      const Footprint footprint = laid_down(placement, picture);
      double worst = 0, brightest = 0;
      for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) {
          const StreakValue sampled = sampled_pixel(placement, picture, x, y, 100);
          worst = std::max(worst, (pixel(footprint, x, y) - sampled).norm());
          brightest = std::max(brightest, sampled.norm());
        }
      }
      // A grid of n x n points misjudges the area left of an edge by about n^-1.5 edge lengths:
      // 1e-3 for n = 100; a pixel of small texels holds the outline only, inside lies the same
      // sum.
      EXPECT_LT(worst, 3e-3 * brightest) << "scale " << scale << ", clip " << clip_row;
    }
  }
}

TEST(StreakFootprint, FluxDoesNotDependOnSizePlaceOrStretch) {
  // Every texel's flux is value x |column x row|, wherever its corners fall.
  const StreakPicture picture = picture_of(5, 40, 2.5, 33.3);
  StreakValue sum = StreakValue::Zero();
  for (const StreakValue& value : picture.values) sum += value;
  for (const double scale : {1.0, 0.3, 0.02, 1e-4}) {
    for (const double path_rows : {33.3, 50.1, 12.0, 1e-3, 0.0}) {
      const Eigen::Vector2d column(0.6 * scale, -0.1 * scale), row(0.13 * scale, 0.4 * scale);
      const StreakPlacement placement = placed({11.37, 9.11}, column, row, path_rows);
      const Footprint footprint = laid_down(placement, picture);
      StreakValue total = StreakValue::Zero();
      for (const StreakValue& value : footprint.values) total += value;
      const StreakValue expected = (0.6 * 0.4 + 0.1 * 0.13) * scale * scale * sum;
      // Rows of a path of no length are slivers of 1e-6 texels: 1e-16 / (1e-6 scale^2) at the pixel
      // borders they cross, which is 1e-10 / 1e-4 at the smallest scale that crosses one.
      EXPECT_LT((total - expected).norm(), 1e-6 * expected.norm()) << scale << ", " << path_rows;
    }
  }
}

TEST(StreakFootprint, WhatLiesBeyondTheScreenIsDropped) {
  const StreakPicture picture = picture_of(3, 5, 1, 3);
  EXPECT_TRUE(laid_down(placed({50, 4}, {1, 0}, {0, 1}, 3), picture).values.empty());
  EXPECT_TRUE(laid_down(placed({-9, 4}, {1, 0}, {0, 1}, 3), picture).values.empty());
  const Footprint half = laid_down(placed({-1, 38}, {1, 0}, {0, 1}, 3), picture);
  EXPECT_LT((pixel(half, 0, 38) - picture.values[1]).norm(), 1e-14);
  EXPECT_LT((pixel(half, 1, 39) - picture.values[5]).norm(), 1e-14);
}

}  // namespace
}  // namespace pluvia
