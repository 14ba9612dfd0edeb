// Where the samples of falling drops go. The sample space of a drop is a unit cube: its time in the
// exposure, and the disc of directions around its reach (radius squared, angle). It is divided into
// strata, boxes that are halved where many samples are wanted, and each gets
//   1/4 of a pass by the drop's size in the picture and the box's volume,
//   3/4 shared evenly by the channels that rain changes, of each in proportion to volume x root
//       mean square of what its samples brought to that channel so far
// (Neyman's allocation for strata whose samples land in different pixels), at least one. Lamps are
// seen through small places of a drop: those are found, and then divided ever finer. A channel has
// a share of its own so that a light of one colour is found however bright those of others are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raytrace/reference_scene.h"

namespace pluvia {

struct Stratum {
  int drop = 0;                                // of FallingDrops::drops
  std::array<std::uint32_t, 3> low = {};       // its lower corner, in units of 2^-most_halvings
  std::array<std::uint32_t, 3> halvings = {};  // of each side
  double samples = 0;                          // so far
  std::array<double, 3> squares = {};          // of what they brought to each channel, summed
};

constexpr std::uint32_t most_halvings = 20;

double volume(const Stratum& stratum);

// A place of the unit cube, in the stratum.
Eigen::Vector3d place_in(const Stratum& stratum, const Eigen::Vector3d& unit);

// One for each drop that can be seen.
std::vector<Stratum> first_strata(const ReferenceScene& scene);

// How many samples each stratum gets in the next pass. Strata of 16 or more are halved first, side
// after side. samples_per_px: of a pass, per square pixel that a drop passes over.
std::vector<int> allocate(const ReferenceScene& scene, double samples_per_px,
                          std::vector<Stratum>& strata);

}  // namespace pluvia
