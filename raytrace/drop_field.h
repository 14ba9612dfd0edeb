// The drops around a scene's camera at one instant: those of the rain space (raytrace/rain_space.h)
// and the scene's single drops, from the seed alone: any time can be asked for, in any order. The
// renderer and every reference read this list; the GPU has the same closed form
// (realtime/shaders/drops_closed.glsl), tested against this one to 1 mm.
//
// The orientation of a drop's transverse mode is relative to the view, as in the 2006 database: the
// set decides it, not the world.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/drop_motion.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"

namespace pluvia {

// What tells one drop of the endless rain from all others, for ever.
struct DropName {
  int size = 0;  // of RainSpace::sizes
  int cell_x = 0, cell_y = 0;
  std::uint32_t number = 0;  // in the cell; of a single drop, its place in the scene
  std::uint32_t round = 0;
  bool single = false;

  auto operator<=>(const DropName&) const = default;
};

struct Drop {
  std::uint64_t id = 0;  // place in this list
  DropName name = {};
  Eigen::Vector3d centre_m = {0, 0, 0};  // at shutter-open
  Eigen::Vector3d velocity_m_s = {0, 0, 0};
  double r0_m = 0;
  int oscillation = 0;    // place of its set among those that there are; number_sets: its number
  double hit_time_s = 0;  // after shutter-open, when the centre reaches the top height below it;
};                        // <= 0: it already has, and is not to be drawn; > 1e26: nothing is below

// A drop of a cell as the closed form of raytrace/rain_space.h has it, wherever the rain's box is.
struct CellDrop {
  std::uint32_t number = 0, round = 0;
  std::uint32_t bits = 0;  // 32 of its own: the oscillation, and what it throws up where it hits
  Eigen::Vector3d centre_m = {0, 0, 0};
};
std::vector<CellDrop> drops_of_cell(const Rain& rain, const RainSpace& space,
                                    const RainSizeSpace& size, const LocalSpace& local,
                                    const RainCell& cell);

// In order of sizes, of cells (y, then x) and of numbers in a cell, then the single drops; also
// those that have hit already. Drops of the rain whose centre is outside its box are left out.
// oscillation_count: number of oscillation sets, >= 1; the field draws one uniformly, and a single
// drop takes its own modulo that number. Throws std::runtime_error for a time that local_space
// refuses. Rain that moves by steps (raytrace/drop_motion.h) is moved there from time 0; its names
// have the number of the drop in its size and, as their round, its fall.
std::vector<Drop> drop_field(const Scene& scene, const RainSpace& space, int oscillation_count,
                             double time_s);

// The same of drops that have been moved there already.
std::vector<Drop> drop_field(const Scene& scene, const RainSpace& space, int oscillation_count,
                             const DropMotion& motion, double time_s);

// What presets and databases call the sets: drops whose sets were places in this list get their
// numbers. sets: of a preset or an atlas, ascending, as many as the field was told.
void number_sets(const std::vector<int>& sets, std::vector<Drop>& drops);

// drop_field in a scene's own rain space, with those numbers.
std::vector<Drop> drops_with_sets(const Scene& scene, const std::vector<int>& sets, double time_s);

}  // namespace pluvia
