#include "raytrace/cone_clip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;

ConeVertex mix(const ConeVertex& a, const ConeVertex& b, double t) {
  return {a.dx + t * (b.dx - a.dx),
          a.dy + t * (b.dy - a.dy),
          a.dz + t * (b.dz - a.dz),
          a.x + t * (b.x - a.x),
          a.y + t * (b.y - a.y),
          a.throughput + t * (b.throughput - a.throughput),
          a.facing + t * (b.facing - a.facing),
          a.margin + t * (b.margin - a.margin)};
}

// Sutherland and Hodgman: keeps where distance(vertex) >= 0; at_cut(vertex) may mend the new ones.
template <typename Distance, typename AtCut>
void clip(ConePolygon& polygon, Distance distance, AtCut at_cut) {
  std::array<double, 24> d;
  int inside = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    d[n] = distance(polygon.vertices[n]);
    inside += d[n] >= 0 ? 1 : 0;
  }
  if (inside == polygon.count) return;
  ConePolygon kept;
  kept.count = 0;
  if (inside > 0) {
    for (int i = 0; i < polygon.count; ++i) {
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(i + 1 == polygon.count ? 0 : i + 1);
      assert(kept.count + 2 <= static_cast<int>(kept.vertices.size()));
      if (d[a] >= 0) kept.vertices[static_cast<std::size_t>(kept.count++)] = polygon.vertices[a];
      if ((d[a] >= 0) != (d[b] >= 0)) {
        ConeVertex& cut = kept.vertices[static_cast<std::size_t>(kept.count++)];
        cut = mix(polygon.vertices[a], polygon.vertices[b], d[a] / (d[a] - d[b]));
        at_cut(cut);
      }
    }
  }
  polygon.count = kept.count;
  std::copy_n(kept.vertices.begin(), kept.count, polygon.vertices.begin());
}

template <typename Distance>
void clip(ConePolygon& polygon, Distance distance) {
  clip(polygon, distance, [](ConeVertex&) {});
}

}  // namespace

Cone make_cone(const Eigen::Vector3d& axis, double half_angle_rad) {
  Cone cone;
  cone.axis = axis;
  cone.half_angle_rad = half_angle_rad;
  const Eigen::Vector3d across1 = axis.unitOrthogonal(), across2 = axis.cross(across1);
  const double disc = pi * std::pow(std::tan(half_angle_rad), 2);
  const double inradius = std::sqrt(disc / (cone_sides * std::tan(pi / cone_sides)));
  for (int k = 0; k < cone_sides; ++k) {
    const double angle = 2 * pi * (k + 0.5) / cone_sides;
    cone.inward[static_cast<std::size_t>(k)] =
        inradius * axis - std::cos(angle) * across1 - std::sin(angle) * across2;
  }
  return cone;
}

void clip_to_cone(const Cone& cone, ConePolygon& polygon) {
  for (const Eigen::Vector3d& n : cone.inward) {
    if (polygon.count == 0) return;
    clip(polygon,
         [&](const ConeVertex& p) { return n.x() * p.dx + n.y() * p.dy + n.z() * p.dz; });
  }
}

void clip_to_facing(ConePolygon& polygon) {
  clip(polygon, [](const ConeVertex& p) { return p.facing; });
  // Throughput of refracted light is negative beyond the outline, and a cut between there and here
  // may fall on either side of zero.
  for (int i = 0; i < polygon.count; ++i) {
    double& throughput = polygon.vertices[static_cast<std::size_t>(i)].throughput;
    throughput = std::max(0.0, throughput);
  }
}

void clip_to_margin(ConePolygon& polygon) {
  clip(
      polygon, [](const ConeVertex& p) { return p.margin; },
      [](ConeVertex& cut) { cut.throughput = 0; });
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
