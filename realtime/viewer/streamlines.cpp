#include "realtime/viewer/streamlines.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

constexpr double radians = std::numbers::pi / 180;
constexpr double least_m_s = 1e-3;
constexpr int lattice[3] = {5, 5, 3};
constexpr int ring = 8;
constexpr int line_steps = 60;

bool is_inside(const Eigen::Vector3d& at, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return (at.array() >= low.array()).all() && (at.array() <= high.array()).all();
}

void add_ring(const WindPrimitive& primitive, std::vector<Eigen::Vector3d>& seeds) {
  if (primitive.kind == WindKind::uniform) return;
  const Eigen::Vector3d x = primitive.axis.unitOrthogonal(), y = primitive.axis.cross(x);
  const double up_m = primitive.kind == WindKind::tornado ? 0.1 * primitive.height_m : 0;
  for (int i = 0; i < ring; ++i) {
    const double turn = 2 * std::numbers::pi * i / ring;
    seeds.push_back(primitive.position_m + up_m * primitive.axis +
                    1.5 * primitive.core_radius_m * (std::cos(turn) * x + std::sin(turn) * y));
  }
}

}  // namespace

Streamline streamline(const Wind& steady, const Eigen::Vector3d& from_m, double step_m, int steps,
                      const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  const auto way = [&](const Eigen::Vector3d& at) -> Eigen::Vector3d {
    const Eigen::Vector3d wind = velocity_m_s(steady, at);
    return wind.norm() < least_m_s ? Eigen::Vector3d(0, 0, 0) : wind.normalized();
  };
  Streamline line = {from_m};
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d& at = line.back();
    const Eigen::Vector3d a = way(at), b = way(at + step_m / 2 * a), c = way(at + step_m / 2 * b);
    const Eigen::Vector3d moved = step_m / 6 * (a + 2 * b + 2 * c + way(at + step_m * c));
    if (a.isZero(0) || !is_inside(at + moved, low_m, high_m)) break;
    line.push_back(at + moved);
  }
  return line;
}

std::vector<Streamline> wind_lines(const Rain& rain, double time_s) {
  const Wind wind = wind_at({.even_m_s = rain.wind_m_s, .primitives = rain.wind}, time_s);
  const Eigen::Vector3d size_m = rain.box_max_m - rain.box_min_m;
  std::vector<Eigen::Vector3d> seeds;
  for (int i = 0; i < lattice[0] * lattice[1] * lattice[2]; ++i) {
    const Eigen::Vector3d share((i % lattice[0] + 0.5) / lattice[0],
                                (i / lattice[0] % lattice[1] + 0.5) / lattice[1],
                                (i / (lattice[0] * lattice[1]) + 0.5) / lattice[2]);
    seeds.push_back(rain.box_min_m + share.cwiseProduct(size_m));
  }
  for (const WindPrimitive& primitive : wind.primitives) add_ring(primitive, seeds);
  std::vector<Streamline> lines;
  for (const Eigen::Vector3d& seed : seeds)
    lines.push_back(streamline(wind, seed, 0.3 * size_m.maxCoeff() / line_steps, line_steps,
                               rain.box_min_m, rain.box_max_m));
  return lines;
}

Turn turn_of(const Eigen::Vector3d& axis) {
  return {std::atan2(std::hypot(axis.x(), axis.y()), axis.z()) / radians,
          std::atan2(axis.x(), axis.y()) / radians};
}

Eigen::Vector3d axis_of(const Turn& turn) {
  const double tilt = turn.tilt_deg * radians, heading = turn.heading_deg * radians;
  return {std::sin(tilt) * std::sin(heading), std::sin(tilt) * std::cos(heading), std::cos(tilt)};
}

}  // namespace pluvia
