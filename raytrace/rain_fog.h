// What dims and veils a scene besides the drops that are drawn: mist, drops too small to be drawn,
// and the drawn sizes where none are drawn, beyond the local space (raytrace/rain_space.h) inside
// the rain's box. So the far rain keeps its extinction and its light, without its drops.
//
// Along a view ray at distance s the extinction is
//   sigma(s) = everywhere + sum over sizes of n pi r0^2 where the ray is in the box and has left
//   the
//              size's local space
// (a density map thins all of it alike, by its mean)
// with one cross-section for each drop (Q = 1, oscillation/size_distribution.h), and
//   tau(d) = int_0^d sigma ds,  B' = B exp(-tau(d)) + L_env (1 - exp(-tau(d)))
// exact for drops that absorb nothing in a uniform environment. The light of lamps and suns that
// the same medium scatters to the camera is the effect `glow` (realtime/shaders/fog.frag).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "raytrace/rain_space.h"
#include "raytrace/scene.h"

namespace pluvia {

struct FogSlab {  // sizes of one direction of fall
  Eigen::Vector3d against_fall = {0, 0, 1};
  double per_m = 0;              // where they are not drawn
  double low_m = 0, high_m = 0;  // of the local slab, from the camera along against_fall
};

struct RainFog {
  double everywhere_per_m = 0;
  double culling_radius_m = 0;
  Eigen::Vector3d box_min_m = {0, 0, 0}, box_max_m = {0, 0, 0};  // from the camera
  std::vector<FogSlab> slabs = {};
};

// The extinction where drops are drawn: mist and drops too small to be drawn. 0 without scene.fog.
double air_per_m(const Scene& scene);

// For scene.camera as it is now. Without scene.fog there is none: all zero.
RainFog rain_fog(const Scene& scene, const RainSpace& space);

// tau(d) along a unit direction from the camera; distance may be infinite where no extinction is
// without end, and tau is infinite where it is.
double fog_depth(const RainFog& fog, const Eigen::Vector3d& direction, double distance_m);

}  // namespace pluvia
