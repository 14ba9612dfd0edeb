// The drops of a scene at one instant, from its seed alone: no stored state, any time can be asked
// for, in any order. The renderer and every reference read this list; the GPU has the same closed
// form (realtime/shaders/rain_common.glsl), tested against this one to 1 mm.
//
// The orientation of a drop's transverse mode is relative to the view, as in the 2006 database: the
// set decides it, not the world.
//
// Drop k of N = round(drops_per_m3 * box volume) falls through the box of height H again and again.
// Its height is box_max.z - ((h_k + t v) mod H), and its (x, y, oscillation) change with the number
// of rounds floor((h_k + t v) / H): a hash of (seed, k, round).
//
// The exact steps: integers modulo 2^32 up to the coordinates, so that a GPU without double takes
// the same decisions. 2^32 phases are one fall through the box: a step of 3 nm for H = 12 m.
//   once a frame, in double:  f = fall_state(rain, t)        f.phase = floor(2^32 (t v mod H) / H)
//                                                            f.round = floor(t v / H)
//   once a scene:             s = rain_seeds(rain.seed)
//   drop k:                   h     = rain_hash(s.phase, k, 0)[0]
//                             phase = h + f.phase
//                             round = f.round + (phase < h ? 1 : 0)          (the sum wrapped)
//                             p     = rain_hash(s.place, k, round)
//                             x     = box_min.x + (box_max.x - box_min.x) (p[0] 2^-32)
//                             y     = box_min.y + (box_max.y - box_min.y) (p[1] 2^-32)
//                             z     = box_max.z - H (phase 2^-32)
//                             oscillation = (p[2] oscillation_count) >> 32
// The last product has 64 bits; in GLSL its high word comes from umulExtended. Exact to 1e-6 m
// after 24 h of simulated time; in float the last lines lose another 2^-24 of the box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"
#include "raytrace/top_height.h"

namespace pluvia {

struct Drop {
  std::uint64_t id = 0;                  // k
  Eigen::Vector3d centre_m = {0, 0, 0};  // at shutter-open
  Eigen::Vector3d velocity_m_s = {0, 0, 0};
  double r0_m = 0;
  int oscillation = 0;    // set index
  double hit_time_s = 0;  // after shutter-open, when the centre reaches the top height below it;
};                        // <= 0: it already has, and is not to be drawn; > 1e26: nothing is below

// Counter-based hash of three integers to 3 x 32 uniform bits: PCG3D of Jarzynski and Olano, "Hash
// Functions for GPU Rendering", JCGT 9(3), 2020. Unsigned arithmetic modulo 2^32, the same in GLSL:
//   v = v * 1664525 + 1013904223;
//   v.x += v.y * v.z;  v.y += v.z * v.x;  v.z += v.x * v.y;
//   v ^= v >> 16;
//   v.x += v.y * v.z;  v.y += v.z * v.x;  v.z += v.x * v.y;
std::array<std::uint32_t, 3> rain_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c);

struct RainSeeds {          // the 64 bits of the seed, mixed: one stream for each use
  std::uint32_t phase = 0;  // [0] of rain_hash(low word, high word, 0)
  std::uint32_t place = 0;  // [1] of the same
};
RainSeeds rain_seeds(std::uint64_t seed);

struct FallState {          // how far every drop has fallen since time 0
  std::uint32_t phase = 0;  // 2^32 phases are one fall through the box
  std::uint32_t round = 0;  // whole falls, modulo 2^32
};

// time_s: 0 .. 1e7 s (116 days), else std::runtime_error. The box is 1 mm high or more.
FallState fall_state(const Rain& rain, double time_s);

// round(drops_per_m3 * box volume).
std::uint32_t drop_count(const Rain& rain);

// All drops in order of id, also those that have hit already.
// oscillation_count: number of oscillation sets, >= 1; the field draws one uniformly.
// top: the height at which a drop ends (raytrace/top_height.h).
std::vector<Drop> drop_field(const Scene& scene, const TopHeight& top, int oscillation_count,
                             double time_s);

}  // namespace pluvia
