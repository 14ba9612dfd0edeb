#include "raytrace/path_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

// Largest third difference along the lines of a cell with the given stride.
template <typename Value, typename Size>
double third_difference(int times, int stride, Value value, Size size) {
  double most = 0;
  const int lines = times * cell_side;
  for (int line = 0; line < lines; ++line) {
    // The line's first node: the digits of `line` on the two other axes.
    const int low = line % stride, high = line / stride;
    const auto at = [&](int k) {
      return value(static_cast<std::size_t>(high * stride * cell_side + low + k * stride));
    };
    most = std::max(most, size(at(0) - at(3) + 3 * (at(2) - at(1))));
  }
  return most;
}

template <typename Direction, typename Power>
PathShape::Bends bends_of(int times, Direction direction, Power power) {
  const auto length = [](const auto& d) { return d.norm(); };
  PathShape::Bends bends;
  for (const int stride : {1, cell_side}) {
    bends.space = std::max(bends.space, third_difference(times, stride, direction, length));
    bends.dim = std::max(bends.dim, third_difference(times, stride, power, length));
  }
  if (times == 1) return bends;
  constexpr int stride = cell_side * cell_side;
  bends.time = third_difference(times, stride, direction, length);
  bends.time_dim = third_difference(times, stride, power, length);
  return bends;
}

PathShape::Bends map_bends(const CellExits& exits, int times) {
  using Eigen::Vector2d;
  return bends_of(
      times, [&](std::size_t n) -> Eigen::Vector3d { return exits[n]->direction; },
      [&](std::size_t n) -> Vector2d {
        return {exits[n]->throughput, 0};
      });
}

// Of the first time's directions: the area of the cell's nine quads.
double spread_of(const CellExits& exits) {
  double area = 0;
  for (std::size_t j = 0; j + 1 < cell_side; ++j) {
    for (std::size_t i = 0; i + 1 < cell_side; ++i) {
      const std::size_t n = cell_side * j + i;
      const Eigen::Vector3d along = exits[n + cell_side + 1]->direction - exits[n]->direction;
      const Eigen::Vector3d across = exits[n + cell_side]->direction - exits[n + 1]->direction;
      area += 0.5 * along.cross(across).norm();
    }
  }
  return area;
}

}  // namespace

PathShape::Bends interface_bends(const CellExits& exits, int times) {
  using Eigen::Vector2d, Eigen::Matrix;
  return bends_of(
      times,
      [&](std::size_t n) {
        Matrix<double, 6, 1> both;
        both << exits[n]->incident, exits[n]->normal;
        return both;
      },
      [&](std::size_t n) -> Vector2d {
        return {exits[n]->power_s, exits[n]->power_p};
      });
}

PathShape path_shape(const ExitField& field, const FieldCell& cell, std::uint64_t signature,
                     CellExits& exits) {
  PathShape shape;
  const auto count = static_cast<std::size_t>(field.times * cell_side * cell_side);
  for (std::size_t n = 0; n < count; ++n) {
    exits[n] = find_exit(field, cell.nodes[n], signature);
    if (!exits[n]) continue;
    ++shape.known;
    shape.centre += exits[n]->direction;
    const double facing = field.nodes[cell.nodes[n]].facing;
    if (facing > 0) {
      ++shape.seen;
      shape.brightest = std::max(shape.brightest, exits[n]->throughput);
      shape.mean_light += facing * exits[n]->throughput / static_cast<double>(count);
    }
  }
  shape.dark = shape.brightest <= 0;
  if (shape.dark) return shape;
  const double length = shape.centre.norm();
  if (length < 1e-6) {  // directions all around: no bounding cone narrower than the sphere
    shape.radius_rad = std::numbers::pi;
    shape.centre = {0, 0, 1};
  } else {
    shape.centre /= length;
    double chord = 0;
    for (const PathExit* exit : exits) {
      if (exit) chord = std::max(chord, (exit->direction - shape.centre).norm());
    }
    shape.radius_rad = 2 * std::asin(std::min(1.0, 0.5 * chord));
  }
  if (shape.known == static_cast<int>(count)) {
    shape.map = map_bends(exits, field.times);
    shape.spread_sr = spread_of(exits);
  }
  return shape;
}

}  // namespace pluvia
