#include "validate/streak_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) {
  return a.x() * b.y() - a.y() * b.x();
}

struct Polygon {  // a parallelogram cut by four lines has at most eight corners
  std::array<Point, 9> corners;
  int count = 0;
  void add(const Point& point) { corners[static_cast<std::size_t>(count++)] = point; }
  const Point& at(int i) const { return corners[static_cast<std::size_t>(i)]; }
};

// The part of the polygon with sign * (coordinate of `axis`) <= sign * limit (Sutherland-Hodgman).
Polygon cut(const Polygon& polygon, int axis, double sign, double limit) {
  Polygon kept;
  for (int i = 0; i < polygon.count; ++i) {
    const Point &a = polygon.at(i), &b = polygon.at((i + 1) % polygon.count);
    const double inside_a = sign * (limit - a[axis]), inside_b = sign * (limit - b[axis]);
    if (inside_a >= 0) kept.add(a);
    if ((inside_a > 0 && inside_b < 0) || (inside_a < 0 && inside_b > 0)) {
      kept.add(a + inside_a / (inside_a - inside_b) * (b - a));
    }
  }
  return kept;
}

double area(const Polygon& polygon) {
  double twice = 0;
  for (int i = 1; i + 1 < polygon.count; ++i) {
    twice += cross(polygon.at(i) - polygon.at(0), polygon.at(i + 1) - polygon.at(0));
  }
  return std::abs(twice) / 2;
}

// Area of the parallelogram inside the pixel whose low corner is the coordinates' origin: numbers
// near 1, so that slivers keep their digits.
double area_in_pixel(const Point& corner, const Point& a, const Point& b) {
  Polygon polygon;
  polygon.add(corner);
  polygon.add(corner + a);
  polygon.add(corner + a + b);
  polygon.add(corner + b);
  return area(cut(cut(cut(cut(polygon, 0, -1, 0), 0, 1, 1), 1, -1, 0), 1, 1, 1));
}

// A row of a cell, or a part of it, that is stretched evenly.
struct Strip {
  int cell_row = 0;
  double row_begin = 0, row_end = 0;  // of the placement
  double share = 0;                   // of the cell row
};

// The inverse of cell_row (raytrace/streak_placement.h).
double placement_row(double cell_row, const StreakPicture& picture, double path_rows) {
  const double top = picture.path_top_row;
  if (cell_row <= top) return cell_row;
  if (cell_row >= top + picture.path_rows) return cell_row - picture.path_rows + path_rows;
  return top + (cell_row - top) / picture.path_rows * path_rows;
}

std::vector<Strip> strips(const StreakPicture& picture, const StreakPlacement& placement) {
  const double ends[2] = {picture.path_top_row, picture.path_top_row + picture.path_rows};
  std::vector<Strip> result;
  for (int row = 0; row < picture.height; ++row) {
    const double cuts[4] = {double(row), std::clamp(ends[0], double(row), row + 1.0),
                            std::clamp(ends[1], double(row), row + 1.0), row + 1.0};
    for (int i = 0; i < 3; ++i) {
      const double share = cuts[i + 1] - cuts[i];
      if (share <= 0) continue;
      Strip strip{row, placement_row(cuts[i], picture, placement.path_rows),
                  placement_row(cuts[i + 1], picture, placement.path_rows), share};
      // A path seen end-on has no length on screen; its flux still needs an area to lie on.
      strip.row_end = std::max(strip.row_end, strip.row_begin + 1e-6);
      if (strip.row_begin >= placement.clip_row) continue;
      if (strip.row_end > placement.clip_row) {
        strip.share *= (placement.clip_row - strip.row_begin) / (strip.row_end - strip.row_begin);
        strip.row_end = placement.clip_row;
      }
      result.push_back(strip);
    }
  }
  return result;
}

struct Box {
  int x0, y0, x1, y1;  // pixels x0 .. x1, y0 .. y1, both included
};

Box pixel_box(const Point& low, const Point& high) {
  return {static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y())),
          static_cast<int>(std::floor(high.x())), static_cast<int>(std::floor(high.y()))};
}

void deposit(const Point& corner, const Point& a, const Point& b, const StreakValue& flux,
             Footprint& footprint) {
  const Point low = corner + a.cwiseMin(0) + b.cwiseMin(0);
  const Point high = corner + a.cwiseMax(0) + b.cwiseMax(0);
  const Box box = pixel_box(low, high);
  const int x0 = footprint.x0, y0 = footprint.y0;
  const int x_last = std::min(box.x1, x0 + footprint.width - 1);
  const int y_last = std::min(box.y1, y0 + footprint.height - 1);
  const bool one_pixel = box.x0 == box.x1 && box.y0 == box.y1;
  const double whole = std::abs(cross(a, b));
  for (int y = std::max(box.y0, y0); y <= y_last; ++y) {
    for (int x = std::max(box.x0, x0); x <= x_last; ++x) {
      const double share = one_pixel ? 1 : area_in_pixel(corner - Point(x, y), a, b) / whole;
      footprint.values[static_cast<std::size_t>((y - y0) * footprint.width + x - x0)] +=
          share * flux;
    }
  }
}

}  // namespace

Footprint empty_footprint(const StreakPlacement& placement,
                          const std::vector<StreakPicture>& pictures, int screen_width,
                          int screen_height) {
  Eigen::AlignedBox2d box;
  for (const StreakPicture& picture : pictures) {
    const double rows = picture.height - picture.path_rows + placement.path_rows;
    for (const double row : {0.0, std::clamp(placement.clip_row, 0.0, rows)}) {
      const Point left = placement.origin_px + row * placement.row_px;
      box.extend(left).extend(left + picture.width * placement.column_px);
    }
  }
  Footprint footprint;
  // A pixel of margin: strips at the very end may be longer by 1e-6 rows.
  const Point low = (box.min() - Point(1, 1)).cwiseMax(0);
  const Point high =
      (box.max() + Point(1, 1)).cwiseMin(Point(screen_width, screen_height) - Point(0.5, 0.5));
  if (!(low.x() <= high.x() && low.y() <= high.y())) return footprint;
  const Box pixels = pixel_box(low, high);
  footprint.x0 = pixels.x0;
  footprint.y0 = pixels.y0;
  footprint.width = pixels.x1 - pixels.x0 + 1;
  footprint.height = pixels.y1 - pixels.y0 + 1;
  footprint.values.assign(
      static_cast<std::size_t>(footprint.width) * static_cast<std::size_t>(footprint.height),
      StreakValue::Zero());
  return footprint;
}

void add_streak(const StreakPlacement& placement, const StreakPicture& picture,
                Footprint& footprint) {
  const double texel_px2 = std::abs(cross(placement.column_px, placement.row_px));
  if (footprint.values.empty() || texel_px2 == 0) return;
  for (const Strip& strip : strips(picture, placement)) {
    const Point left = placement.origin_px + strip.row_begin * placement.row_px;
    const Point down = (strip.row_end - strip.row_begin) * placement.row_px;
    for (int u = 0; u < picture.width; ++u) {
      const StreakValue& value =
          picture.values[static_cast<std::size_t>(strip.cell_row * picture.width + u)];
      if ((value.array() == 0).all()) continue;
      deposit(left + u * placement.column_px, placement.column_px, down,
              texel_px2 * strip.share * value, footprint);
    }
  }
}

}  // namespace pluvia
