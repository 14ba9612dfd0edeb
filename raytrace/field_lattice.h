// The nodes of an exit field (raytrace/exit_field.h): points of the drop's surface on a lattice of
// directions from its star centre and of times, asked for by cells of every size and traced once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "raytrace/exit_field.h"
#include "raytrace/exit_paths.h"

namespace pluvia {

// A node's place on the finest lattice of space and time.
struct LatticePlace {
  int i = 0, j = 0, k = 0;
  std::uint64_t key() const {
    return (static_cast<std::uint64_t>(k) << 42) | (static_cast<std::uint64_t>(j) << 21) |
           static_cast<std::uint64_t>(i);
  }
};

struct AskedNode {
  std::uint32_t number = 0;
  Eigen::Vector3d direction = {0, 0, 0};  // from the star centre; zero: beyond the map's edge
};

// The square map, the drop at the lattice's times, and the nodes traced so far.
struct FieldLattice {
  const View& view;
  const FieldOptions& options;
  ExitField& field;                     // gets nodes, exits and what is left in them
  std::vector<DropInstant> drops = {};  // one per time of the finest lattice
  int side = 0;                         // steps per side
  double reach_rad = 0;                 // the map covers [-reach, reach]^2
  Eigen::Vector3d e1 = {}, e2 = {};     // its axes, across the view
  std::unordered_map<std::uint64_t, std::uint32_t> index = {};  // of nodes, by their place
  std::vector<std::vector<AskedNode>> asked = {};               // by time

  double step_rad() const { return 2 * reach_rad / side; }
};

// drops: of one instant, or of (cell_side - 1) 2^time_depth + 1. The three references stay with the
// lattice.
FieldLattice make_field_lattice(std::vector<DropInstant> drops, const View& view,
                                const FieldOptions& options, ExitField& field);

// The number of the node there: one that is new is traced by the next trace_asked().
std::uint32_t ask_node(FieldLattice& lattice, const LatticePlace& place);

void trace_asked(FieldLattice& lattice);

}  // namespace pluvia
