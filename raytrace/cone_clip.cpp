#include "raytrace/cone_clip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace pluvia {

namespace {

constexpr int sides = 16;
constexpr double pi = std::numbers::pi;

ConeVertex mix(const ConeVertex& a, const ConeVertex& b, double t) {
  return {a.u + t * (b.u - a.u), a.v + t * (b.v - a.v), a.x + t * (b.x - a.x),
          a.y + t * (b.y - a.y), a.throughput + t * (b.throughput - a.throughput)};
}

// Sutherland and Hodgman: keeps where distance(vertex) >= 0.
template <typename Distance>
void clip(ConePolygon& polygon, Distance distance) {
  ConePolygon kept;
  kept.count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const ConeVertex& a = polygon.vertices[static_cast<std::size_t>(i)];
    const ConeVertex& b = polygon.vertices[static_cast<std::size_t>((i + 1) % polygon.count)];
    const double da = distance(a), db = distance(b);
    assert(kept.count + 2 <= static_cast<int>(kept.vertices.size()));
    if (da >= 0) kept.vertices[static_cast<std::size_t>(kept.count++)] = a;
    if ((da >= 0) != (db >= 0)) {
      kept.vertices[static_cast<std::size_t>(kept.count++)] = mix(a, b, da / (da - db));
    }
  }
  polygon = kept;
}

struct Side {
  double nu, nv;  // outward normal of a side of the unit polygon
};

const std::array<Side, sides>& polygon_sides() {
  static const std::array<Side, sides> table = [] {
    std::array<Side, sides> t = {};
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * pi * (k + 0.5) / sides;
      t[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
    }
    return t;
  }();
  return table;
}

}  // namespace

Cone make_cone(const Eigen::Vector3d& axis, double half_angle_rad) {
  Cone cone;
  cone.axis = axis;
  cone.across1 = axis.unitOrthogonal();
  cone.across2 = axis.cross(cone.across1);
  cone.half_angle_rad = half_angle_rad;
  const double disc = pi * std::pow(std::tan(half_angle_rad), 2);
  cone.circumradius = std::sqrt(disc / (0.5 * sides * std::sin(2 * pi / sides)));
  return cone;
}

bool gnomonic(const Cone& cone, const Eigen::Vector3d& direction, ConeVertex& vertex) {
  const double along = direction.dot(cone.axis);
  if (along < 0.2) return false;
  vertex.u = direction.dot(cone.across1) / along;
  vertex.v = direction.dot(cone.across2) / along;
  return true;
}

void clip_to_cone(const Cone& cone, ConePolygon& polygon) {
  const double inradius = cone.circumradius * std::cos(pi / sides);
  double largest = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const ConeVertex& p = polygon.vertices[static_cast<std::size_t>(i)];
    largest = std::max(largest, p.u * p.u + p.v * p.v);
  }
  if (largest <= inradius * inradius) return;
  for (const Side& side : polygon_sides()) {
    if (polygon.count == 0) return;
    clip(polygon, [&](const ConeVertex& p) { return inradius - side.nu * p.u - side.nv * p.v; });
  }
}

void clip_to_columns(ConePolygon& polygon, double low, double high) {
  clip(polygon, [&](const ConeVertex& p) { return p.x - low; });
  clip(polygon, [&](const ConeVertex& p) { return high - p.x; });
}

PolygonFlux polygon_flux(const ConePolygon& polygon) {
  PolygonFlux flux;
  for (int i = 1; i + 1 < polygon.count; ++i) {  // a fan from the first vertex
    const ConeVertex& a = polygon.vertices[0];
    const ConeVertex& b = polygon.vertices[static_cast<std::size_t>(i)];
    const ConeVertex& c = polygon.vertices[static_cast<std::size_t>(i + 1)];
    const double area = 0.5 * std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
    flux.area += area;
    flux.throughput += area * (a.throughput + b.throughput + c.throughput) / 3;
  }
  if (flux.area > 0) flux.throughput /= flux.area;
  return flux;
}

}  // namespace pluvia
