#include "raytrace/drop_intersect.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/Geometry>

namespace pluvia {

namespace {

constexpr double half_pi = std::numbers::pi / 2;

// The ray in the plane through the star centre; lengths relative to the drop's scale.
struct RayPlane {
  Eigen::Vector3d e = {1, 0, 0}, d = {0, 0, 1};
  double b = 0;
  double psi = 0;  // of the origin
};

RayPlane ray_plane(const DropInstant& drop, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o = (origin_m - drop.origin_m) / drop.surface.scale;
  const double along = o.dot(direction);
  const Eigen::Vector3d closest = o - along * direction;
  const double b = closest.norm();
  RayPlane plane;
  plane.d = direction;
  plane.b = b;
  plane.e = b > 1e-14 ? Eigen::Vector3d(closest / b) : direction.unitOrthogonal();
  plane.psi = std::atan2(along, b);
  return plane;
}

// Values at one angle of the ray; h is the surface's radius over its scale.
struct RayPoint {
  double c = 1, s = 0;
  double g = 0, slope = 0;  // G and G'
  HarmonicValue<double> surface = {};
  Eigen::Vector3d u = {1, 0, 0};
};

RayPoint point_at(const DropInstant& drop, const RayPlane& ray, double psi) {
  RayPoint p;
  p.c = std::cos(psi);
  p.s = std::sin(psi);
  p.u = p.c * ray.e + p.s * ray.d;
  p.surface = evaluate(drop.surface, p.u);
  const double turn = p.surface.gradient.dot(p.c * ray.d - p.s * ray.e);
  p.g = p.surface.h * p.c - ray.b;
  p.slope = turn * p.c - p.surface.h * p.s;
  return p;
}

// Largest h >= 0 with f + f' t - m t^2 / 2 >= 0 on [0, h]; f >= 0.
double safe_step(double f, double slope, double m) {
  const double root = std::sqrt(slope * slope + 2 * m * f);
  if (slope < 0) return 2 * f / (root - slope);
  return m > 0 ? (slope + root) / m : 2 * half_pi;
}

// The first root of G ahead of the ray's origin, as a point of the ray.
std::optional<RayPoint> first_root(const DropInstant& drop, const RayPlane& ray, RaySide side) {
  const bool outside = side == RaySide::outside;
  if (outside && (ray.b >= drop.bound_h)) return std::nullopt;
  const double m = walk_bend(drop, side);
  const double sign = outside ? -1 : 1;
  double psi = ray.psi;
  bool left_start = false;
  for (int step = 0; step < walk_step_limit; ++step) {
    const RayPoint p = point_at(drop, ray, psi);
    if (outside && psi > 0 && p.c * drop.bound_h < ray.b) return std::nullopt;
    const double f = std::max(0.0, sign * p.g);
    const double slope = sign * p.slope;
    if (f <= walk_root_tolerance) {
      if (slope < 0 && (left_start || outside)) return p;
      if (slope <= 0 && !left_start) return std::nullopt;  // from inside, grazing its own start
      if (slope <= 0) return p;
    }
    const double h = safe_step(f, slope, m);
    // Below the spacing of doubles the ray stands on the root.
    if (left_start && h <= 1e-15) return p;
    psi += h;
    left_start = true;
    if (psi >= half_pi) {
      if (outside) return std::nullopt;
      psi = half_pi;
    }
  }
  throw std::logic_error("drop intersection: no root within 10000 certified steps");
}

}  // namespace

double walk_bend(const DropInstant& drop, RaySide side) {
  const double bend = std::hypot(drop.bound_bend, 2 * drop.bound_slope);
  return side == RaySide::outside ? bend : bend + drop.bound_h;
}

std::optional<DropHit> intersect_drop(const DropInstant& drop, const Eigen::Vector3d& origin_m,
                                      const Eigen::Vector3d& direction, RaySide side) {
  const RayPlane ray = ray_plane(drop, origin_m, direction);
  const auto p = first_root(drop, ray, side);
  if (!p) return std::nullopt;
  const Eigen::Vector3d tangential = p->surface.gradient - p->surface.gradient.dot(p->u) * p->u;
  DropHit hit;
  hit.position = drop.origin_m + drop.surface.scale * p->surface.h * p->u;
  hit.normal = (p->u - tangential / p->surface.h).normalized();
  hit.distance = (hit.position - origin_m).dot(direction);
  return hit;
}

bool drop_occludes(const DropInstant& drop, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction) {
  return first_root(drop, ray_plane(drop, origin_m, direction), RaySide::outside).has_value();
}

}  // namespace pluvia
