// Light from points at infinity (delta lights: cones of half angle 0): the points of a map where
// the exit direction is the light's, each with the light that it sends to the camera,
//
//   throughput x |dA / dOmega|   [px^2/sr per unit irradiance],
//
// A the area in the picture, Omega the exit directions' solid angle: the limit of a cone's flux as
// it shrinks. What it cannot promise: at a fold of the map (a caustic) dA / dOmega has no bound.
// The light that passes through a pixel during an exposure stays finite, since folds move, but a
// sum over moments converges to it only slowly there, like the mean of draws from a distribution
// without variance; two glints that are about to merge there, closer than 2^-12 of a cell, may be
// missed. Light directions away from folds converge as those of cones do.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "raytrace/cone_clip.h"

namespace pluvia {

struct Glint {
  double x = 0, y = 0;  // in the picture, as ConeVertex has them
  double light = 0;     // > 0, finite
};

// A smooth map over the unit square, with its continuation a little beyond.
using PatchMap = std::function<ConeVertex(double u, double v)>;

// Calls take(k, glint) for the glints of unit directions lights[k] in 0 <= u, v < 1: half-open, so
// that a light on the common edge of two patches counts once. Only what the camera sees and what
// passes light is a glint.
void find_glints(const PatchMap& map, std::span<const Eigen::Vector3d> lights,
                 const std::function<void(std::size_t, const Glint&)>& take);

// The glint of a triangle with direction, picture and throughput linear in between. Triangles that
// tile a surface share their edges' points out: each belongs to one of them.
std::optional<Glint> glint_in_triangle(const Eigen::Vector3d& light, const ConeVertex& a,
                                       const ConeVertex& b, const ConeVertex& c);

}  // namespace pluvia
