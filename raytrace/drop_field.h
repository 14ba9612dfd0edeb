// The drops of a scene at one instant, from its seed alone: no stored state, any time can be asked for,
// in any order. The renderer and every reference read this list; the GPU has the same closed form
// (realtime/shaders/rain_common.glsl), tested against this one to 1 mm.
//
// The orientation of a drop's transverse mode is relative to the view, as in the 2006 database: the set
// decides it, not the world.
//
// Drop k of N = round(drops_per_m3 * box volume) falls through the box of height H again and again. Its
// height is box_max.z - ((h_k + t v) mod H), and its (x, y, oscillation) change with the number of
// rounds floor((h_k + t v) / H): a hash of (seed, k, round). Computed in double; exact to 1 mm after
// 24 h of simulated time.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"
#include "raytrace/top_height.h"

namespace pluvia {

struct Drop {
  std::uint64_t id = 0;                        // k
  Eigen::Vector3d centre_m = {0, 0, 0};        // at shutter-open
  Eigen::Vector3d velocity_m_s = {0, 0, 0};
  double r0_m = 0;
  int oscillation = 0;                         // set index
  double t0_s = 0;                             // oscillation time at shutter-open: 0 in gn2006
  double hit_time_s = 0;                       // after shutter-open, when the centre reaches the top height
};                                             // below it; <= 0: it already has, and is not to be drawn

// Counter-based hash of three integers to 32 uniform bits; the same integers in GLSL (PCG3D).
std::uint32_t rain_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c);

// Number of oscillation sets: the field draws a set uniformly from 0 .. oscillation_count - 1.
// top: the height at which a drop ends (raytrace/top_height.h).
std::vector<Drop> drop_field(const Scene& scene, const TopHeight& top, int oscillation_count,
                             double time_s);

}  // namespace pluvia
