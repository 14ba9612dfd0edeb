// How one path's map looks in a cell of an exit field (raytrace/exit_field.h): what decides whether
// the polynomial through its nodes is the map, and how much depends on it.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "raytrace/exit_field.h"

namespace pluvia {

// Of the nodes of a cell, nullptr where a node has not the path; the first `times` x 16 count.
using CellExits = std::array<const PathExit*, cell_side * cell_side * cell_side>;

struct PathShape {
  int known = 0, seen = 0;             // nodes that have the path, and face the camera
  bool dark = true;                    // no visible node passes light
  Eigen::Vector3d centre = {0, 0, 0};  // mean direction, unit
  double radius_rad = 0;               // largest angle of a node's direction from it
  double brightest = 0;                // throughput of a visible node
  double mean_light = 0;               // mean over all nodes of throughput x facing
  double spread_sr = 0;                // solid angle of the directions at the cell's first time; 0
                                       // where nodes are missing
  // Largest third differences.
  struct Bends {
    double space = 0, time = 0;    // of directions
    double dim = 0, time_dim = 0;  // of throughputs, of powers
  };
  Bends map = {};
};

// Sets exits to those of the path in the cell.
PathShape path_shape(const ExitField& field, const FieldCell& cell, std::uint64_t signature,
                     CellExits& exits);

// Of what meets the path's last interface instead: directions and normals, powers of s and of p.
// All nodes have the path.
PathShape::Bends interface_bends(const CellExits& exits, int times);

}  // namespace pluvia
