// Which lights of the atlas may be the nearest to a direction: a table that leaves a shader a few
// to look at instead of all.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace pluvia {

constexpr int candidate_cells = 48;  // along each side of the square

// Directions (unit, not necessarily) fold onto an octahedron, and that onto the square [-1, 1]^2:
// p = (x, y) / (|x| + |y| + |z|), for z < 0 turned outward to (1 - |p.y|) sign(p.x), (1 - |p.x|)
// sign(p.y). Index y candidate_cells + x of the direction's cell.
int candidates_cell(const Eigen::Vector3d& direction);

// Value i, for cell i, and value i + 1: first place of its lights in this same array and of the
// next cell's. A cell holds every light that is the nearest, or within 1e-3 of it, to any of its
// directions, ascending. lights: unit, at least one.
std::vector<std::uint32_t> light_candidates(const std::vector<Eigen::Vector3d>& lights);

}  // namespace pluvia
