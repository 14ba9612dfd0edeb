#include "raytrace/drop_silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr int outline_corners = 128;
constexpr int lines_per_column = 8;
constexpr double rows_per_slice = 0.5;  // two shapes a row, as the tracer has at least
constexpr int fewest_slices = 64;       // .. and 30 for each period of a mode, of which few fit in

// The rows of the drop's centre during a slice.
struct Fall {
  double first = 0, last = 0;
};

double ramp2(double x) {
  return x > 0 ? 0.5 * x * x : 0;
}

// Mean over the fall of the part of a chord [high, low] (rows relative to the centre) above `row`.
double part_above(double row, double high, double low, const Fall& fall) {
  const double sum = ramp2(row - fall.first - high) - ramp2(row - fall.last - high) -
                     ramp2(row - fall.first - low) + ramp2(row - fall.last - low);
  return sum / (fall.last - fall.first);
}

struct Canvas {
  const StreakFrame& frame;
  std::vector<double> values = {};

  void add_chord(int column, double high, double low, const Fall& fall, double weight) {
    const int first = std::max(0, static_cast<int>(std::floor(fall.first + high)));
    const int end = std::min(frame.height_px, static_cast<int>(std::ceil(fall.last + low)));
    double above = part_above(first, high, low, fall);
    for (int row = first; row < end; ++row) {
      const double next = part_above(row + 1, high, low, fall);
      values[static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.width_px) +
             static_cast<std::size_t>(column)] += weight * std::max(0.0, next - above);
      above = next;
    }
  }
};

// Rows where the vertical line at x meets the outline (x to the right, y up, in pixels), ascending.
// Each edge owns its left end alone, so that their number is even.
std::vector<double> crossings(const std::vector<Eigen::Vector2d>& outline_px, double x) {
  std::vector<double> rows;
  for (std::size_t i = 0; i < outline_px.size(); ++i) {
    const Eigen::Vector2d& a = outline_px[i];
    const Eigen::Vector2d& b = outline_px[(i + 1) % outline_px.size()];
    if ((a.x() <= x) == (b.x() <= x)) continue;
    rows.push_back(-(a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x())));
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

void add_outline(Canvas& canvas, const std::vector<Eigen::Vector2d>& outline_px, const Fall& fall,
                 double weight) {
  for (int line = 0; line < canvas.frame.width_px * lines_per_column; ++line) {
    const double x = (line + 0.5) / lines_per_column - canvas.frame.centre_column;
    const std::vector<double> rows = crossings(outline_px, x);
    for (std::size_t i = 0; i + 1 < rows.size(); i += 2) {
      canvas.add_chord(line / lines_per_column, rows[i], rows[i + 1], fall,
                       weight / lines_per_column);
    }
  }
}

}  // namespace

// The largest of samples every 5 degrees, then the value at the vertex of the parabola through its
// neighbours.
double outline_distance_m(const DropInstant& drop, const Eigen::Vector3d& e,
                          const Eigen::Vector3d& to_camera) {
  constexpr int half = 12;  // up to 60 degrees: r cos b is at most half the largest radius beyond
  constexpr double step = 5 * pi / 180;
  const auto distance_m = [&](double b) {
    const Eigen::Vector3d u = std::cos(b) * e + std::sin(b) * to_camera;
    return surface_radius_m(drop, u) * std::cos(b);
  };
  std::array<double, 2 * half + 1> samples = {};
  for (int i = -half; i <= half; ++i) {
    samples[static_cast<std::size_t>(i + half)] = distance_m(i * step);
  }
  const auto top = std::max_element(samples.begin(), samples.end());
  if (top == samples.begin() || top == samples.end() - 1) return *top;
  const double rise = *(top + 1) - *(top - 1), bend = *(top + 1) - 2 * *top + *(top - 1);
  if (!(bend < 0)) return *top;
  const auto index = static_cast<double>(top - samples.begin() - half);
  return std::max(*top, distance_m((index - rise / (2 * bend)) * step));
}

std::vector<Eigen::Vector2d> drop_outline_m(const DropInstant& drop, const View& view,
                                            int corners) {
  const Eigen::Vector2d centre(drop.origin_m.dot(view.right), drop.origin_m.dot(view.up));
  const double turn = 2 * pi / corners;
  const double widening = std::sqrt(turn / std::sin(turn));  // of the inscribed polygon
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < corners; ++i) {
    const Eigen::Vector2d across(std::cos(i * turn), std::sin(i * turn));
    const Eigen::Vector3d e = across.x() * view.right + across.y() * view.up;
    outline.push_back(centre + widening * outline_distance_m(drop, e, view.to_camera) * across);
  }
  return outline;
}

std::vector<float> silhouette_coverage(const DropShape& drop, double view_elevation_deg,
                                       double exposure_s, const StreakFrame& frame) {
  const View view = view_from_elevation(view_elevation_deg);
  const int slices =
      is_rigid(drop)
          ? 1
          : std::max(fewest_slices, static_cast<int>(std::ceil(frame.path_rows / rows_per_slice)));
  Canvas canvas = {frame};
  canvas.values.assign(
      static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px), 0.0);
  for (int slice = 0; slice < slices; ++slice) {
    const DropInstant instant = drop_at(drop, (slice + 0.5) / slices * exposure_s);
    std::vector<Eigen::Vector2d> outline = drop_outline_m(instant, view, outline_corners);
    for (Eigen::Vector2d& corner : outline) corner /= frame.pixel_m;
    const Fall fall = {frame.path_top_row + frame.path_rows * slice / slices,
                       frame.path_top_row + frame.path_rows * (slice + 1) / slices};
    add_outline(canvas, outline, fall, 1.0 / slices);
  }
  return {canvas.values.begin(), canvas.values.end()};
}

}  // namespace pluvia
