// A wind (raytrace/wind_field.h) at the nodes of a regular grid over a box, between them linear
// along each axis; outside, that of the nearest place of the box. A node at or below the surface
// below it, as a top height (raytrace/top_height.h) has it, is inside an object: there the wind is
// 0. So air that is blown against a wall stops within a cell of it and does not go around: a drop
// is carried against the wall, and ends there (raytrace/drop_motion.h).
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "raytrace/top_height.h"
#include "raytrace/wind_field.h"

namespace pluvia {

constexpr int wind_nodes = 64;  // along each axis

struct WindGrid {
  Eigen::Vector3d low_m = {0, 0, 0};           // node (0, 0, 0)
  Eigen::Vector3d step_m = {1, 1, 1};          // between nodes, > 0
  int nodes = wind_nodes;                      // along each axis, >= 2
  std::vector<Eigen::Vector3d> wind_m_s = {};  // x fastest, z slowest
};

inline std::size_t node_index(const WindGrid& grid, int x, int y, int z) {
  const auto n = static_cast<std::size_t>(grid.nodes);
  return (static_cast<std::size_t>(z) * n + static_cast<std::size_t>(y)) * n +
         static_cast<std::size_t>(x);
}

// Of a steady wind. top: heights over the world's x and y (a frame that falls straight down).
WindGrid make_wind_grid(const Wind& steady, const Eigen::Vector3d& low_m,
                        const Eigen::Vector3d& high_m, const TopHeight& top,
                        int nodes = wind_nodes);

Eigen::Vector3d velocity_m_s(const WindGrid& grid, const Eigen::Vector3d& at_m);

}  // namespace pluvia
