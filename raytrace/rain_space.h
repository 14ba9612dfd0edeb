// The rain space: where around the camera drops are drawn, and which drops those are. After Creus
// (2010), with the drops of an endless rain instead of a stored set.
//
// Axes. Drops of one size have one velocity; z of their frame points against it. A drop keeps x and
// y of its frame while it falls. For a fall straight down the frame is the world's.
//
// Local space. Of the endless rain a renderer draws the prism around the camera along the fall: the
// cells (below) whose centre is within the culling radius, and of them the slab of the local height
// around the camera, shifted to stay inside the rain's box as far as it can.
//
// Drops. The plane z = 0 of a frame is divided into square cells; each holds a Poisson number of
// drops for every local height h, at heights h (u_k + n) - s t, n any integer (the round), s the
// speed. The slab shows the one n that lies inside it; where the drop stands in the cell and how it
// oscillates is a hash of (cell, k, n). A drop therefore stays where it is in the world whichever
// way the camera goes: up, down or around, the slab only shows others (the run position with its
// height correction does the same for a stored set). Nothing repeats, and nothing is stored.
//
// Rain that moves by steps (raytrace/drop_motion.h) has no cells: its local space is the box, its
// frames are the world's.
//
// The exact steps: integers modulo 2^32 up to the coordinates, so that a GPU without double takes
// the same decisions. 2^32 phases are one local height: a step of 5 nm for 20 m.
//   once a scene:  stream = rain_hash(seed's low word, its high word, index of the size)
//   a cell (x, y): keys   = rain_hash(stream[0], x, y)
//                  count  = quantile of Poisson's law at (rain_hash(stream[1], x, y)[0] + 1/2)
//                  2^-32
//   a frame, in double, B the slab's lower end:
//                  run   = (s t + B) / h;  round = floor(run);  phase = floor(2^32 (run - round))
//   drop k:        start = rain_hash(keys[0], k, 0)[0]
//                  up    = start - phase                        (modulo 2^32)
//                  n     = round + (start < phase ? 1 : 0)
//                  p     = rain_hash(keys[1], k, n)
//                  x     = cell (x + p[0] 2^-32),  y alike,  z = B + h up 2^-32
//                  oscillation = (p[2] oscillation_count) >> 32
//                  there is no such drop where rain_hash(keys[2], k, n)[0] 2^-32 is not below the
//                  density (raytrace/density_map.h) of the place where it fell through its map
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/density_map.h"
#include "raytrace/fall_frame.h"
#include "raytrace/scene.h"
#include "raytrace/top_height.h"

namespace pluvia {

// Counter-based hash of three integers to 3 x 32 uniform bits: PCG3D of Jarzynski and Olano, "Hash
// Functions for GPU Rendering", JCGT 9(3), 2020. Unsigned arithmetic modulo 2^32, the same in GLSL:
//   v = v * 1664525 + 1013904223;
//   v.x += v.y * v.z;  v.y += v.z * v.x;  v.z += v.x * v.y;
//   v ^= v >> 16;
//   v.x += v.y * v.z;  v.y += v.z * v.x;  v.z += v.x * v.y;
std::array<std::uint32_t, 3> rain_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c);

struct Extent {
  double low_m = 0, high_m = 0;
};

constexpr Extent no_extent = {1e300, -1e300};

inline Extent joined(const Extent& a, const Extent& b) {
  return {std::min(a.low_m, b.low_m), std::max(a.high_m, b.high_m)};
}

struct RainSizeSpace {
  RainSize drops = {};
  FallFrame frame = {};
  double speed_m_s = 0;
  double cell_m = 0;                          // 0: not of the rain, only of single drops
  int top = 0;                                // of RainSpace::tops
  Extent box_x = {}, box_y = {}, box_z = {};  // the box along the frame's axes
  Eigen::Matrix2d density_axes = Eigen::Matrix2d::Zero();  // texel of the density map =
  Eigen::Vector2d density_origin = {0, 0};                 // origin + axes (x, y)
  std::array<std::uint32_t, 3> stream = {};
  std::vector<double> count_at_most = {};  // [n]: probability of n drops or fewer in a cell
};

struct RainSpace {
  std::vector<RainSizeSpace> sizes = {};  // the rain's, then those that single drops add
  std::vector<int> single_sizes = {};     // the size of each single drop
  std::vector<TopHeight> tops = {};  // one for each direction of fall, of the surfaces as posed
  double culling_radius_m = 0;
  double local_height_m = 0;
  double lost_share = 0;      // bound of what of the visible rain lies outside, as estimated below
  double expected_drops = 0;  // in the local space, at most, wherever the camera's path leads
};

// n pi r0^2, one cross-section for each drop (Q = 1, oscillation/size_distribution.h), 1/m.
double extinction_per_m(const RainSize& size);

// lost_share. Along a view ray the rain at distance s adds to the picture in proportion to its
// extinction sigma, the sum of all sizes, and to what is left of its light, exp(-sigma s). Of all
// that along the picture's rays, from the camera to where they leave the rain's box, the part
// outside the local space is lost; surfaces are ignored: they hide more of the far rain than of the
// near. With several directions of fall, and along a camera path, the greatest share counts. Where
// the scene leaves both sizes open, the pair of least volume with a share of at most
// rain.lost_share is taken.
//
// Throws std::runtime_error when more than most_local_drops would be needed.
constexpr double most_local_drops = 2e7;
RainSpace make_rain_space(const Scene& scene);

// The share that a local space of these sizes loses, as above.
double lost_share(const Scene& scene, double culling_radius_m, double local_height_m);

struct LocalSpace {                   // of one size at one instant
  Eigen::Vector2d centre_m = {0, 0};  // of the prism in the frame's x, y
  double floor_m = 0;                 // B
  std::uint32_t phase = 0;
  std::uint32_t round = 0;
};

// time_s: 0 .. 1e7 s (116 days), else std::runtime_error.
LocalSpace local_space(const RainSpace& space, int size, const Eigen::Vector3d& camera_m,
                       double time_s);

// The same with a slab that begins elsewhere: its drops are others of the same endless rain.
LocalSpace local_space_at(const RainSpace& space, int size, const Eigen::Vector3d& camera_m,
                          double floor_m, double time_s);

struct RainCell {
  int x = 0, y = 0;
  std::uint32_t count = 0;
  std::array<std::uint32_t, 3> keys = {};
};

RainCell rain_cell(const RainSizeSpace& size, int x, int y);

struct CellRange {  // x0 .. x1 - 1, y0 .. y1 - 1
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// The cells around those of the prism, as far as the box reaches; empty (x0 >= x1) where there are
// none.
CellRange local_cells(const RainSpace& space, int size, const LocalSpace& local);

// The area across the fall of a range of cells, times the density there: not less than what falls
// there, and 0 only where nothing does. m^2.
double rain_area_m2(const Rain& rain, const RainSizeSpace& size, const CellRange& cells);

// The share of the rain that falls on a range of cells: the mean of the density map's texels there.
double rain_share(const Rain& rain, const RainSizeSpace& size, const CellRange& cells);

// Whether a cell belongs to the prism.
bool in_prism(const RainSpace& space, int size, const LocalSpace& local, int x, int y);

}  // namespace pluvia
