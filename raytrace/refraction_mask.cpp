#include "raytrace/refraction_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include "raytrace/drop_intersect.h"
#include "raytrace/drop_silhouette.h"

namespace pluvia {
namespace {

// Of the outline as a polygon: its area errs by less than 1e-9, its radius by 1e-4.
constexpr int outline_corners = 256;

// Of a round map: within the 1e-6 to which the outline is known, 0.003 of the way from axis to rim.
constexpr double round_rim_share = 1 - 1e-5;

void refuse_wrong_grid(const MaskGrid& grid) {
  if (grid.size_px < 1 || grid.size_px > 4096)
    throw std::invalid_argument(fmt::format("size_px = {}; expected 1 .. 4096", grid.size_px));
  if (!(grid.half_width_m > 0 && std::isfinite(grid.half_width_m)))
    throw std::invalid_argument(fmt::format("half_width_m = {}; expected > 0", grid.half_width_m));
}

Eigen::Vector2d pixel_centre_m(const MaskGrid& grid, int column, int row) {
  const double width_m = 2 * grid.half_width_m;
  return {((column + 0.5) / grid.size_px - 0.5) * width_m,
          (0.5 - (row + 0.5) / grid.size_px) * width_m};
}

// A star-shaped outline about its own centre.
struct Outline {
  const DropInstant& drop;
  const View& view;
  Eigen::Vector2d centre_m = {drop.origin_m.dot(view.right), drop.origin_m.dot(view.up)};

  Eigen::Vector2d place_m(const Eigen::Vector2d& wanted_m) const {
    const Eigen::Vector2d from_centre = wanted_m - centre_m;
    const double distance_m = from_centre.norm();
    if (distance_m < 1e-12 * drop.surface.scale) return centre_m;
    const Eigen::Vector2d across = from_centre / distance_m;
    return centre_m + std::min(distance_m, rim_share * rim_m(across)) * across;
  }

  Eigen::Vector2d round_place_m(const Eigen::Vector2d& q) const {
    const double angle = std::min(q.norm(), 1.0) * std::numbers::pi / 2;
    if (angle < 1e-12) return centre_m;
    const Eigen::Vector2d across = q.normalized();
    return centre_m + std::min(std::sin(angle), round_rim_share) * rim_m(across) * across;
  }

  double rim_m(const Eigen::Vector2d& across) const {
    const Eigen::Vector3d in_space = across.x() * view.right + across.y() * view.up;
    return outline_distance_m(drop, in_space, view.to_camera);
  }
};

using Polygon = std::vector<Eigen::Vector2d>;

// The part of a polygon with sign (p[axis] - bound) >= 0.
Polygon clip(const Polygon& polygon, int axis, double bound, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
    if (da >= 0) kept.push_back(a);
    if ((da >= 0) != (db >= 0)) kept.push_back(a + da / (da - db) * (b - a));
  }
  return kept;
}

double area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

// A polygon that is not convex falls apart where a line cuts it twice: the pieces hang together by
// edges along the line, there and back, which have no area.
std::vector<double> coverage_of(const Polygon& outline, const MaskGrid& grid) {
  const double pixel_m = 2 * grid.half_width_m / grid.size_px;
  std::vector<double> coverage;
  for (int row = 0; row < grid.size_px; ++row) {
    const double top_m = grid.half_width_m - row * pixel_m;
    const Polygon strip = clip(clip(outline, 1, top_m, -1), 1, top_m - pixel_m, 1);
    for (int column = 0; column < grid.size_px; ++column) {
      const double left_m = column * pixel_m - grid.half_width_m;
      const Polygon part = clip(clip(strip, 0, left_m, 1), 0, left_m + pixel_m, -1);
      coverage.push_back(std::min(1.0, area(part) / (pixel_m * pixel_m)));
    }
  }
  return coverage;
}

struct MaskTracer {
  const DropInstant& drop;
  const View& view;
  const PathOptions& paths;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();  // rows: right, up, onward

  // The exits at one place, order by order; returns what the brightest path of each leaves out.
  double trace(const Eigen::Vector2d& place_m, std::vector<MaskExit>& orders) const {
    const double far_m = 4 * drop.bound_h * drop.surface.scale + drop.origin_m.norm();
    const Eigen::Vector3d from =
        place_m.x() * view.right + place_m.y() * view.up + far_m * view.to_camera;
    const auto hit = intersect_drop(drop, from, -view.to_camera, RaySide::outside);
    if (!hit) throw std::logic_error("a line of sight within the outline misses the drop");
    std::vector<PathExit> exits;
    trace_exits(drop, hit->position, hit->normal, view.to_camera, paths, exits);
    std::vector<double> brightest(orders.size(), -1.0);
    for (const PathExit& exit : exits) {
      const auto order = static_cast<std::size_t>(exit.order);
      orders[order].weight += exit.throughput;
      if (exit.throughput <= brightest[order]) continue;
      brightest[order] = exit.throughput;
      orders[order].direction = (axes * exit.direction).normalized();
    }
    double astray = 0;
    for (std::size_t k = 0; k < orders.size(); ++k)
      astray += orders[k].weight - std::max(0.0, brightest[k]);
    return astray;
  }
};

// place_m: of a pixel.
template <typename Place>
void trace_pixels(const DropInstant& drop, const View& view, const PathOptions& paths,
                  RefractionMask& mask, const Place& place_m) {
  const auto size = static_cast<std::size_t>(mask.grid.size_px), pixels = size * size;
  const auto orders = static_cast<std::size_t>(paths.max_order) + 1;
  mask.exits.resize(orders * pixels);
  mask.tail.resize(pixels);
  MaskTracer tracer{drop, view, paths};
  tracer.axes << view.right.transpose(), view.up.transpose(), -view.to_camera.transpose();
  std::vector<double> astray(pixels);
  tbb::parallel_for(std::size_t(0), pixels, [&](std::size_t i) {
    std::vector<MaskExit> exits(orders);
    astray[i] =
        tracer.trace(place_m(static_cast<int>(i % size), static_cast<int>(i / size)), exits);
    double sum = 0;
    for (std::size_t k = 0; k < orders; ++k) {
      mask.exits[k * pixels + i] = exits[k];
      sum += exits[k].weight;
    }
    mask.tail[i] = 1 - sum;
  });
  mask.astray = *std::max_element(astray.begin(), astray.end());
}

}  // namespace

Eigen::Vector2d mask_place_m(const DropInstant& drop, const View& view, const MaskGrid& grid,
                             int column, int row) {
  return Outline{drop, view}.place_m(pixel_centre_m(grid, column, row));
}

RefractionMask trace_refraction_mask(const DropInstant& drop, const View& view,
                                     const MaskGrid& grid, const PathOptions& paths) {
  refuse_wrong_grid(grid);
  RefractionMask mask = {.grid = grid, .max_order = paths.max_order};
  mask.coverage = coverage_of(drop_outline_m(drop, view, outline_corners), grid);
  trace_pixels(drop, view, paths, mask,
               [&](int column, int row) { return mask_place_m(drop, view, grid, column, row); });
  return mask;
}

RefractionMask trace_round_mask(const DropInstant& drop, const View& view, int size_px,
                                const PathOptions& paths) {
  if (size_px < 2 || size_px > 4096)
    throw std::invalid_argument(fmt::format("size_px = {}; expected 2 .. 4096", size_px));
  RefractionMask mask = {.grid = {.size_px = size_px}, .max_order = paths.max_order};
  const Outline outline = {drop, view};
  const double half = 0.5 * (size_px - 1);
  trace_pixels(drop, view, paths, mask, [&](int column, int row) {
    return outline.round_place_m({column / half - 1, 1 - row / half});
  });
  return mask;
}

std::vector<double> outline_from_origin_m(const DropInstant& drop, const View& view, int angles) {
  const Polygon outline = drop_outline_m(drop, view, outline_corners);
  std::vector<double> distances;
  for (int k = 0; k < angles; ++k) {
    const double angle = 2 * std::numbers::pi * k / angles;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle)), beside(-ray.y(), ray.x());
    double farthest_m = -1;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      const double sa = a.dot(beside), sb = b.dot(beside);
      if ((sa < 0) == (sb < 0)) continue;
      farthest_m = std::max(farthest_m, (a + sa / (sa - sb) * (b - a)).dot(ray));
    }
    if (!(farthest_m > 0))
      throw std::invalid_argument("the drop's outline does not enclose its origin");
    distances.push_back(farthest_m);
  }
  return distances;
}

}  // namespace pluvia
