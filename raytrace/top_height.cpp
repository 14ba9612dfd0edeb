#include "raytrace/top_height.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Core>

namespace pluvia {
namespace {

constexpr float no_surface_m = -1e30f;
constexpr double max_texels = 1 << 26;

// Twice the signed area of (a, b, p) seen from above. The ends are put in one order first, so that
// the two triangles of a shared edge get the same number with opposite signs and leave no gap.
double edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y) {
  const bool swap = b.x() < a.x() || (b.x() == a.x() && b.y() < a.y());
  const Eigen::Vector3d& p = swap ? b : a;
  const Eigen::Vector3d& q = swap ? a : b;
  const double area = (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
  return swap ? -area : area;
}

struct Span {  // texels first .. last
  int first, last;
};

Span texels_over(double low, double high, double origin, double texel_m, int count) {
  // One texel more on each side than rounding could lose; the edge tests decide.
  const double first = std::floor((low - origin) / texel_m) - 1;
  const double last = std::ceil((high - origin) / texel_m) + 1;
  return {static_cast<int>(std::clamp<double>(first, 0, count)),
          static_cast<int>(std::clamp<double>(last, -1, count - 1))};
}

void rasterise(TopHeight& top, const std::array<Eigen::Vector3d, 3>& corner) {
  const Eigen::Vector3d &a = corner[0], &b = corner[1], &c = corner[2];
  const double area = edge(a, b, c.x(), c.y());
  if (area == 0) return;
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  Eigen::Vector2d slope = -normal.head<2>() / normal.z();
  if (!(slope.norm() <= steepest_slope)) slope.setZero();
  const auto [low_x, high_x] = std::minmax({a.x(), b.x(), c.x()});
  const auto [low_y, high_y] = std::minmax({a.y(), b.y(), c.y()});
  const Span columns = texels_over(low_x, high_x, top.min_x_m, top.texel_m, top.width);
  const Span rows = texels_over(low_y, high_y, top.min_y_m, top.texel_m, top.height);
  const auto [low_z, high_z] = std::minmax({a.z(), b.z(), c.z()});
  // How much an edge's share grows from a texel's centre to its corner.
  const double half = top.texel_m / 2 / std::abs(area);
  const auto corner_gain = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return half * (std::abs(q.x() - p.x()) + std::abs(q.y() - p.y()));
  };
  const double gain_a = corner_gain(b, c), gain_b = corner_gain(c, a), gain_c = corner_gain(a, b);
  for (int j = rows.first; j <= rows.last; ++j) {
    for (int i = columns.first; i <= columns.last; ++i) {
      const double x = top.min_x_m + (i + 0.5) * top.texel_m;
      const double y = top.min_y_m + (j + 0.5) * top.texel_m;
      const double beside = top.texel_m / 2;
      if (x + beside < low_x || x - beside > high_x || y + beside < low_y || y - beside > high_y)
        continue;
      const double wa = edge(b, c, x, y) / area;
      const double wb = edge(c, a, x, y) / area;
      const double wc = edge(a, b, x, y) / area;
      if (wa + gain_a < 0 || wb + gain_b < 0 || wc + gain_c < 0) continue;
      const double plane = (wa * a.z() + wb * b.z() + wc * c.z()) / (wa + wb + wc);
      const double z = std::clamp(plane, low_z, high_z);  // the centre may lie beside the triangle
      TopTexel& texel =
          top.texels[static_cast<std::size_t>(j) * static_cast<std::size_t>(top.width) +
                     static_cast<std::size_t>(i)];
      const auto height = static_cast<float>(z);
      if (!(height > texel.z_m)) continue;
      texel = {height, static_cast<float>(slope.x()), static_cast<float>(slope.y())};
    }
  }
}

std::array<Eigen::Vector3d, 3> corners(const TopHeight& top, const Mesh& mesh, std::size_t first) {
  std::array<Eigen::Vector3d, 3> corner;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d p = mesh.positions_m[mesh.indices[first + i]].cast<double>();
    corner[i] = {p.dot(top.frame.x), p.dot(top.frame.y), p.dot(top.frame.z)};
  }
  return corner;
}

// All that rasterise may touch.
TexelRect texels_below(const TopHeight& top, const Mesh& mesh, std::size_t first,
                       std::size_t count) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (std::size_t t = first; t < first + count; t += 3) {
    for (const Eigen::Vector3d& p : corners(top, mesh, t)) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const Span x = texels_over(low.x(), high.x(), top.min_x_m, top.texel_m, top.width);
  const Span y = texels_over(low.y(), high.y(), top.min_y_m, top.texel_m, top.height);
  const TexelRect rect = {x.first, y.first, x.last + 1, y.last + 1};
  return rect.empty() ? TexelRect{} : rect;
}

std::ptrdiff_t place_of(const TopHeight& top, int x, int y) {
  return static_cast<std::ptrdiff_t>(y) * top.width + x;
}

}  // namespace

TopHeight top_height(const Mesh& mesh, const FallFrame& frame, const PlaneRect& rect,
                     double texel_m, std::size_t index_count) {
  assert(texel_m > 0);
  TopHeight top = {
      .min_x_m = rect.min_x_m, .min_y_m = rect.min_y_m, .texel_m = texel_m, .frame = frame};
  if (!(rect.min_x_m < rect.max_x_m && rect.min_y_m < rect.max_y_m)) return top;
  const double width = std::ceil((rect.max_x_m - rect.min_x_m) / texel_m);
  const double height = std::ceil((rect.max_y_m - rect.min_y_m) / texel_m);
  if (!(width * height <= max_texels))
    throw std::runtime_error(fmt::format(
        "top height of the rain: {:.0f} x {:.0f} texels of {} m; expected at most {:.0f} in all",
        width, height, texel_m, max_texels));
  top.width = static_cast<int>(width);
  top.height = static_cast<int>(height);
  top.texels.resize(static_cast<std::size_t>(width * height));
  const std::size_t end = std::min(index_count, mesh.indices.size());
  for (std::size_t t = 0; t + 2 < end; t += 3) rasterise(top, corners(top, mesh, t));
  float lowest = -no_surface_m;
  for (const TopTexel& texel : top.texels) {
    if (texel.z_m > no_surface_m) lowest = std::min(lowest, texel.z_m);
  }
  top.lowest_m = lowest < -no_surface_m ? static_cast<double>(lowest) : 0;
  return top;
}

TopPatch cover(TopHeight& top, const Mesh& mesh, std::size_t first, std::size_t count) {
  TopPatch patch = {.rect = texels_below(top, mesh, first, count)};
  const TexelRect& rect = patch.rect;
  if (rect.empty()) return patch;
  for (int y = rect.y0; y < rect.y1; ++y)
    patch.under.insert(patch.under.end(), top.texels.begin() + place_of(top, rect.x0, y),
                       top.texels.begin() + place_of(top, rect.x1, y));
  for (std::size_t t = first; t < first + count; t += 3) rasterise(top, corners(top, mesh, t));
  return patch;
}

void uncover(TopHeight& top, const TopPatch& patch) {
  const TexelRect& rect = patch.rect;
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto row =
        patch.under.begin() + static_cast<std::ptrdiff_t>(y - rect.y0) * (rect.x1 - rect.x0);
    std::copy_n(row, rect.x1 - rect.x0, top.texels.begin() + place_of(top, rect.x0, y));
  }
}

const TopTexel* texel_at(const TopHeight& top, double x_m, double y_m) {
  const double i = std::floor((x_m - top.min_x_m) / top.texel_m);
  const double j = std::floor((y_m - top.min_y_m) / top.texel_m);
  if (!(i >= 0 && i < top.width && j >= 0 && j < top.height)) return nullptr;
  return &top.texels[static_cast<std::size_t>(j) * static_cast<std::size_t>(top.width) +
                     static_cast<std::size_t>(i)];
}

double height_at(const TopHeight& top, double x_m, double y_m) {
  const TopTexel* texel = texel_at(top, x_m, y_m);
  if (!texel) return static_cast<double>(no_surface_m);
  const double i = std::floor((x_m - top.min_x_m) / top.texel_m);
  const double j = std::floor((y_m - top.min_y_m) / top.texel_m);
  const double dx = x_m - top.min_x_m - (i + 0.5) * top.texel_m;
  const double dy = y_m - top.min_y_m - (j + 0.5) * top.texel_m;
  return static_cast<double>(texel->z_m) + dx * static_cast<double>(texel->slope_x) +
         dy * static_cast<double>(texel->slope_y);
}

}  // namespace pluvia
