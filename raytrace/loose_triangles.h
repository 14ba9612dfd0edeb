// Triangles between the nodes of a cell, where only those are to be trusted.
#pragma once

#include <cmath>
#include <optional>

#include "raytrace/light_integrator.h"

namespace pluvia {

// Where in a cell's time a slice is: between the nodes `before` and the next.
struct BetweenNodes {
  std::size_t before = 0;
  double share = 0;
};

inline BetweenNodes between_nodes(const ExitField& field, double cell_share) {
  if (field.times == 1) return {};
  const double at = (cell_side - 1) * cell_share;
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, cell_side - 2.0));
  return {before, at - static_cast<double>(before)};
}

// Corner of the quad at (i, j) of a cell, k = 0 .. 3 around it: its place among a plane's 16 nodes.
inline std::size_t corner_place(std::size_t i, std::size_t j, std::size_t k) {
  return cell_side * (j + (k / 2)) + i + ((k == 1 || k == 2) ? 1 : 0);
}

inline ConeVertex to_vertex(const Node& n) {
  return {n[dir_x], n[dir_y], n[dir_z], n[column], n[row], n[light], n[facing], 1};
}

// A place of a cell between two times of its nodes: in between where both are there, else as at the
// nearer time. node_at(time, place) gives an optional Node.
template <typename NodeAt>
std::optional<Node> node_between(const BetweenNodes& t, int times, std::size_t place,
                                 NodeAt node_at) {
  std::optional<Node> before = node_at(t.before, place);
  if (times == 1) return before;
  const std::optional<Node> after = node_at(t.before + 1, place);
  if (!before || !after) return t.share < 0.5 ? before : after;
  for (std::size_t c = 0; c < quantities; ++c)
    (*before)[c] += t.share * ((*after)[c] - (*before)[c]);
  return before;
}

// Calls add(a, b, c) for the triangles of a cell of which only the nodes are to be trusted: two for
// each quad with four nodes, one for each with three.
template <typename NodeAt, typename Add>
void for_loose_triangles(const BetweenNodes& t, int times, NodeAt node_at, Add add) {
  std::array<std::optional<Node>, 16> nodes;
  for (std::size_t n = 0; n < 16; ++n) nodes[n] = node_between(t, times, n, node_at);
  for (std::size_t j = 0; j + 1 < cell_side; ++j) {
    for (std::size_t i = 0; i + 1 < cell_side; ++i) {
      std::array<ConeVertex, 4> corners;
      std::size_t count = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& node = nodes[corner_place(i, j, k)];
        if (node) corners[count++] = to_vertex(*node);
      }
      if (count >= 3) add(corners[0], corners[1], corners[2]);
      if (count == 4) add(corners[0], corners[2], corners[3]);
    }
  }
}

}  // namespace pluvia
