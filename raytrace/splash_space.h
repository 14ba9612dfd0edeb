// Which drops of the rain splash, and where: those that have hit a surface (raytrace/top_height.h)
// less than a splash's duration ago, or will while the shutter is open. The rain's closed form goes
// on below the surface, so that of any drop both where and when it hit are known; a splash is
// there whenever its drop was, and nowhere else.
//
// The slab of raytrace/rain_space.h ends with the rain's box and may not reach what is below a
// surface, or all surfaces. Splashes are therefore looked for in slabs of their own, one on top of
// the other from the lowest surface, less what a drop falls in a splash's duration, to the highest.
// Across the fall they end with the prism of the local space, within its bound of what is lost.
//
// A drop that leaves the rain's box falls on until it hits: a splash is where the fall that leads
// to it has come through the box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "raytrace/drop_field.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "raytrace/splash.h"

namespace pluvia {

// Droplets on surfaces so steep that they fly longer are not followed farther.
constexpr double most_splash_s = 1;

// What tells the splashes of a size apart is a key, 16 bits of the drop's own:
//   bits = rain_hash(key, 0, 0);  variant = bits[0] % splash_variants;  turn = 2 pi bits[1] 2^-32
// Of the single drop with that place in the scene:
constexpr std::uint32_t single_splash_key(std::size_t i) {
  return static_cast<std::uint32_t>(i * 40503u) & 0xffffu;
}

struct HeightBlocks {  // of a TopHeight, by squares of texels
  int width = 0, height = 0;
  std::vector<Extent> extents = {};  // along the fall, row by row; low > high: there is none
  Extent all = {};
};

struct SplashSpace {  // for each of RainSpace::sizes
  std::vector<SplashTable> tables = {};
  std::vector<double> duration_s = {};
  std::vector<double> reach_m = {};
  std::vector<HeightBlocks> blocks = {};  // of RainSpace::tops
};

// What moving parts do to it hangs on the blocks alone: durations are those for any pose.
SplashSpace make_splash_space(const Scene& scene, const RainSpace& space);

// Brings the blocks of a top up to date after move_top (raytrace/scene_tops.h) changed texels of
// it.
void move_splashes(const TopHeight& top, const std::vector<TexelRect>& changed,
                   HeightBlocks& blocks);

struct SplashSlab {
  int size = 0;
  LocalSpace local = {};
};

// In order of sizes, then from below. For scene.camera as it is now; only of sizes that splash.
std::vector<SplashSlab> splash_slabs(const Scene& scene, const RainSpace& space,
                                     const SplashSpace& splashes, double time_s);

// The cells of a slab whose drops may splash in the picture, in order (y, then x).
std::vector<RainCell> splash_cells(const Scene& scene, const RainSpace& space,
                                   const SplashSpace& splashes, const SplashSlab& slab);

struct Splash {
  int size = 0;
  int variant = 0;      // of the table
  double turn_rad = 0;  // of it about the normal
  Eigen::Vector3d place_m = {0, 0, 0};
  Eigen::Vector3d normal = {0, 0, 1};  // of the surface
  double since_s = 0;                  // the hit, at shutter-open; < 0: still to come
};

// All of a frame, in order of slabs and cells (y, then x), single drops last: what the renderer's
// shaders find too.
std::vector<Splash> splash_field(const Scene& scene, const RainSpace& space,
                                 const SplashSpace& splashes, double time_s);

}  // namespace pluvia
