#include "raytrace/streak_frame.h"

#include <algorithm>
#include <cmath>

namespace pluvia {

namespace {

// A uniform distribution narrower than this share of a row is treated as that wide: the sum of two
// uniforms below divides by both widths.
constexpr double narrowest_rows = 0.01;

struct Spread {
  double low = 0, high = 0;
};

Spread at_least(double low, double high) {
  const double lack = narrowest_rows - (high - low);
  return lack > 0 ? Spread{low - 0.5 * lack, high + 0.5 * lack} : Spread{low, high};
}

double ramp2(double x) {
  return x > 0 ? 0.5 * x * x : 0;
}

// Distribution function of the sum of two independent uniforms.
struct SumOfTwo {
  Spread a, b;
  double scale = 0;
  SumOfTwo(const Spread& first, const Spread& second)
      : a(first), b(second), scale(1 / ((a.high - a.low) * (b.high - b.low))) {}
  double below(double t) const {
    if (t >= a.high + b.high) return 1;
    return std::clamp(
        scale * (ramp2(t - a.low - b.low) - ramp2(t - a.low - b.high) - ramp2(t - a.high - b.low)),
        0.0, 1.0);
  }
};

void deposit_column(StreakWindow& window, int plane, int column, const SumOfTwo& spread,
                    double amount) {
  const double low = spread.a.low + spread.b.low, high = spread.a.high + spread.b.high;
  const int first = std::max(window.first_row, static_cast<int>(std::floor(low)));
  const int last = std::min(window.first_row + window.rows - 1, static_cast<int>(std::floor(high)));
  double before = spread.below(first);
  for (int r = first; r <= last; ++r) {
    // A distribution never falls; the cancellation of squares in it may, in the last digits.
    const double after = std::max(before, spread.below(r + 1));
    window.row(plane, r - window.first_row)[column] += amount * (after - before);
    before = after;
  }
}

}  // namespace

StreakWindow make_window(const StreakFrame& frame, int planes, double radius_m,
                         double first_centre_row, double last_centre_row) {
  const double margin = radius_m / frame.pixel_m + 1;
  StreakWindow window;
  window.first_row = std::max(0, static_cast<int>(std::floor(first_centre_row - margin)));
  const int end = std::min(frame.height_px, static_cast<int>(std::ceil(last_centre_row + margin)));
  window.rows = std::max(0, end - window.first_row);
  window.width_px = frame.width_px;
  window.planes = planes;
  window.values.assign(static_cast<std::size_t>(planes) * static_cast<std::size_t>(window.rows) *
                           static_cast<std::size_t>(window.width_px),
                       0.0);
  return window;
}

void deposit(StreakWindow& window, int plane, const Travel& travel, ConePolygon polygon,
             double weight) {
  if (polygon.count < 3) return;
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
  for (int i = 0; i < polygon.count; ++i) {
    const ConeVertex& p = polygon.vertices[static_cast<std::size_t>(i)];
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  const int first = std::max(0, static_cast<int>(std::floor(left)));
  const int last = std::min(window.width_px - 1, static_cast<int>(std::floor(right)));
  const SumOfTwo spread(at_least(low, high), at_least(travel.first_row, travel.last_row));
  for (int column = first; column <= last; ++column) {
    ConePolygon part = polygon;
    if (left < column || right > column + 1) clip_to_columns(part, column, column + 1.0);
    const PolygonFlux flux = polygon_flux(part);
    if (flux.area > 0) {
      deposit_column(window, plane, column, spread, weight * flux.area * flux.throughput);
    }
  }
}

}  // namespace pluvia
