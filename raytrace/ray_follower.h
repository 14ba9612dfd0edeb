// How brute force (raytrace/brute_force.h) follows a ray through a drop, one after the other: every
// interface splits it, polarisation is a Stokes vector, and interfaces are Mueller matrices. What
// the ray meets is the analytic drop or a mesh of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "raytrace/embree_drop.h"
#include "raytrace/exit_paths.h"

namespace pluvia {

using Stokes = Eigen::Vector4d;  // I, Q, U, V; Q > 0 along the reference axis

// Turns the reference axis of a Stokes vector from `from` to `to`, both perpendicular to
// `direction`.
inline Stokes turn_reference(const Stokes& stokes, const Eigen::Vector3d& direction,
                             const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double c = from.dot(to), s = direction.cross(from).dot(to);
  const double c2 = c * c - s * s, s2 = 2 * c * s;
  return {stokes[0], c2 * stokes[1] + s2 * stokes[2], c2 * stokes[2] - s2 * stokes[1], stokes[3]};
}

// Light on its way: reference is the axis of its Stokes vector.
struct StokesRay {
  Eigen::Vector3d position, direction, reference;
  Stokes stokes;
  bool inside = false;
  int order = 0;
};

// Mueller matrix in the s/p frame from power shares of s and p and the phase difference of p
// against s.
inline Stokes apply_mueller(const Stokes& in, double s_share, double p_share, double cos_phase,
                            double sin_phase) {
  const double plus = 0.5 * (s_share + p_share), minus = 0.5 * (s_share - p_share);
  const double cross = std::sqrt(s_share * p_share);
  return {plus * in[0] + minus * in[1], minus * in[0] + plus * in[1],
          cross * (cos_phase * in[2] + sin_phase * in[3]),
          cross * (cos_phase * in[3] - sin_phase * in[2])};
}

// The surfaces that a ray may meet, from outside or inside.
struct AnalyticSurface {
  const DropInstant& drop;
  const EmbreeDrop& embree;

  std::optional<DropHit> meet(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction,
                              RaySide side) const {
    return embree.intersect(drop, from_m, direction, side);
  }
};

struct MeshSurface {
  const DropInstant& drop;
  const MeshDrop& mesh;
  double gap = 0;  // SphereMesh's
  bool polished = false;

  // Every ray starts off the triangles that it comes from: floats end at 1e-7 of the distance.
  std::optional<DropHit> meet(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction,
                              RaySide) const {
    const double off_m = (polished ? 4 * gap : 1e-5) * drop.surface.scale;
    const Eigen::Vector3d start_m = from_m + off_m * direction;
    return polished ? mesh.intersect_polished(drop, start_m, direction)
                    : mesh.intersect(start_m, direction);
  }
};

template <typename Surface>
struct Follower {
  const Surface& surface;
  const PathOptions& options;
  bool polarised = true;  // false: light leaves every interface unpolarised

  // Calls escape(direction, power) for every ray that leaves.
  template <typename Escape>
  void follow(StokesRay ray, const Eigen::Vector3d& outward, const Escape& escape) const {
    const double n1 = ray.inside ? options.refractive_index : 1;
    const double n2 = ray.inside ? 1 : options.refractive_index;
    const Eigen::Vector3d normal = ray.inside ? Eigen::Vector3d(-outward) : outward;
    const double cos1 = -normal.dot(ray.direction);
    if (cos1 <= 0) return;
    Eigen::Vector3d s = ray.direction.cross(normal);
    s = s.norm() > 1e-12 ? Eigen::Vector3d(s.normalized()) : ray.reference;
    const Stokes in = turn_reference(ray.stokes, ray.direction, ray.reference, s);
    const double sin2 = n1 / n2 * std::sqrt(std::max(0.0, 1 - cos1 * cos1));

    StokesRay reflected = ray;
    reflected.direction = (ray.direction + 2 * cos1 * normal).normalized();
    reflected.reference = s;
    if (sin2 >= 1) {
      // tan(delta / 2) = cos1 sqrt(sin1^2 - (n2/n1)^2) / sin1^2, delta the phase of p minus that of
      // s.
      const double sin1_2 = 1 - cos1 * cos1;
      const double half =
          std::atan(cos1 * std::sqrt(std::max(0.0, sin1_2 - n2 * n2 / (n1 * n1))) / sin1_2);
      reflected.stokes = apply_mueller(in, 1, 1, std::cos(2 * half), std::sin(2 * half));
      next(reflected, escape);
      return;
    }
    const double cos2 = std::sqrt(1 - sin2 * sin2);
    const double rs = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    const double rp = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    reflected.stokes = apply_mueller(in, rs * rs, rp * rp, rs * rp < 0 ? -1 : 1, 0);
    next(reflected, escape);

    StokesRay refracted = ray;
    refracted.inside = !ray.inside;
    refracted.direction = (n1 / n2 * ray.direction + (n1 / n2 * cos1 - cos2) * normal).normalized();
    refracted.reference = s;
    refracted.stokes = apply_mueller(in, 1 - rs * rs, 1 - rp * rp, 1, 0);
    next(refracted, escape);
  }

  template <typename Escape>
  void next(StokesRay ray, const Escape& escape) const {
    if (ray.inside && ++ray.order > options.max_order) return;
    if (ray.stokes[0] < options.min_power) return;
    if (!polarised) ray.stokes.tail<3>().setZero();
    const auto hit =
        surface.meet(ray.position, ray.direction, ray.inside ? RaySide::inside : RaySide::outside);
    if (hit) {
      ray.position = hit->position;
      follow(ray, hit->normal, escape);
    } else if (!ray.inside) {
      escape(ray.direction, ray.stokes[0]);
    }
  }
};

}  // namespace pluvia
