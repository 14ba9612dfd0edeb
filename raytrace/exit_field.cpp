#include "raytrace/exit_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "raytrace/drop_intersect.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr std::uint32_t no_node = 0xffffffffu;

int deepest(const FieldOptions& options) {
  return std::max({options.bend_depth, options.break_depth, options.silhouette_depth});
}

// The square map and its nodes on the finest lattice; traces a node when it is first asked for.
struct Lattice {
  const DropInstant& drop;
  const View& view;
  const FieldOptions& options;
  ExitField& field;
  int side = 0;      // lattice points per side
  double reach = 0;  // the map covers [-reach, reach]^2
  Eigen::Vector3d e1 = {}, e2 = {};
  std::vector<std::uint32_t> index = {};

  double spacing_at(int depth) const {  // between the nodes of a cell
    return 2 * reach / (2.0 * options.base_cells * (1 << depth));
  }

  std::uint32_t node(int i, int j) {
    std::uint32_t& slot = index[static_cast<std::size_t>(j) * static_cast<std::size_t>(side) +
                                static_cast<std::size_t>(i)];
    if (slot == no_node) {
      slot = static_cast<std::uint32_t>(field.nodes.size());
      field.nodes.push_back(trace(i, j));
    }
    return slot;
  }

  FieldNode trace(int i, int j) {
    const double step = 2 * reach / (side - 1);
    const double shift = options.shift * spacing_at(0);
    const double x = -reach + step * i + shift, y = -reach + step * j + shift;
    const double r = std::hypot(x, y);
    FieldNode node;
    if (r >= pi) return node;
    const double sinc = r > 1e-9 ? std::sin(r) / r : 1;
    const Eigen::Vector3d u = std::cos(r) * view.to_camera + sinc * (x * e1 + y * e2);
    const Eigen::Vector3d normal = surface_normal(drop, u);
    if (normal.dot(view.to_camera) <= 0) return node;
    const Eigen::Vector3d position = drop.origin_m + surface_radius_m(drop, u) * u;
    if (drop_occludes(drop, position, view.to_camera)) return node;
    node.visible = true;
    node.xy_m = {position.dot(view.right), position.dot(view.up)};
    trace_paths(node, position, normal);
    return node;
  }

  void trace_paths(FieldNode& node, const Eigen::Vector3d& position,
                   const Eigen::Vector3d& normal) {
    node.first_exit = static_cast<std::uint32_t>(field.exits.size());
    const PathRemainder left =
        trace_exits(drop, position, normal, view.to_camera, options.paths, field.exits);
    node.exit_count = static_cast<std::uint32_t>(field.exits.size()) - node.first_exit;
    for (std::uint32_t k = 0; k < node.exit_count; ++k) {
      node.throughput += field.exits[node.first_exit + k].throughput;
    }
    field.remainder.beyond_order += left.beyond_order;
    field.remainder.given_up += left.given_up;
    field.remainder.lost += left.lost;
    ++field.traced_nodes;
  }
};

using Nine = std::array<std::uint32_t, 9>;  // a cell's nodes, row by row

// How one path's map looks in a cell.
struct PathShape {
  int present = 0;                     // of the nine nodes
  Eigen::Vector3d centre = {0, 0, 0};  // mean direction, unit
  double radius = 0;                   // largest distance (chord) of a node's direction from it
  double bend = 0;                     // largest distance of a middle from the mean of its ends
  bool dark = true;                    // no node passes light
  bool breaks_off = false;             // some do, some do not
};

PathShape path_shape(const ExitField& field, const Nine& nodes, std::uint64_t signature) {
  PathShape shape;
  std::array<const PathExit*, 9> exits = {};
  int lit = 0;
  for (std::size_t k = 0; k < 9; ++k) {
    exits[k] = find_exit(field, nodes[k], signature);
    if (!exits[k]) continue;
    ++shape.present;
    shape.centre += exits[k]->direction;
    lit += exits[k]->throughput > 0 ? 1 : 0;
  }
  shape.dark = lit == 0;
  shape.breaks_off = lit < 9;
  const double length = shape.centre.norm();
  if (length < 1e-6) {  // directions all around: no bounding cone narrower than the sphere
    shape.radius = 2;
    return shape;
  }
  shape.centre /= length;
  for (const PathExit* exit : exits) {
    if (exit) shape.radius = std::max(shape.radius, (exit->direction - shape.centre).norm());
  }
  if (shape.present < 9) return shape;
  constexpr std::size_t middles[6][3] = {{0, 1, 2}, {6, 7, 8}, {0, 3, 6},
                                         {2, 5, 8}, {3, 4, 5}, {1, 4, 7}};
  for (const auto& m : middles) {
    const Eigen::Vector3d mean = 0.5 * (exits[m[0]]->direction + exits[m[2]]->direction);
    shape.bend = std::max(shape.bend, (exits[m[1]]->direction - mean).norm());
  }
  return shape;
}

struct Refiner {
  Lattice& lattice;
  const ConeLights& lights;
  const FieldOptions& options;
  ExitField& field;

  bool light_within(const Eigen::Vector3d& centre, double angle_rad) const {
    if (angle_rad >= pi) return !lights.directions.empty();
    const double cosine = std::cos(angle_rad);
    return std::any_of(lights.directions.begin(), lights.directions.end(),
                       [&](const Eigen::Vector3d& l) { return l.dot(centre) > cosine; });
  }

  bool path_needs_refinement(const Nine& nodes, std::uint64_t signature, int depth) const {
    const PathShape shape = path_shape(field, nodes, signature);
    if (shape.dark) return false;
    const double cone = lights.half_angle_rad;
    const bool bends = shape.bend > options.bend_tolerance * cone || shape.present < 9;
    if (depth < options.bend_depth && bends) {
      // Where nodes are missing, what is missing may lie beyond what is seen.
      const double beyond =
          shape.present < 9 ? shape.radius + 3 * lattice.spacing_at(depth) : shape.bend;
      if (light_within(shape.centre, 1.2 * shape.radius + beyond + cone)) return true;
    }
    return depth < options.break_depth && shape.breaks_off &&
           light_within(shape.centre, 1.2 * shape.radius + cone);
  }

  bool needs_refinement(const Nine& nodes, int depth, int visible) const {
    if (visible < 9 && depth < options.silhouette_depth) return true;
    for (std::size_t k = 0; k < 9; ++k) {
      const FieldNode& node = field.nodes[nodes[k]];
      for (std::uint32_t e = 0; e < node.exit_count; ++e) {
        const std::uint64_t signature = field.exits[node.first_exit + e].signature;
        bool seen = false;  // a path is judged at the first node that has it
        for (std::size_t before = 0; before < k && !seen; ++before) {
          seen = find_exit(field, nodes[before], signature) != nullptr;
        }
        if (!seen && path_needs_refinement(nodes, signature, depth)) return true;
      }
    }
    return false;
  }

  void leaf(const Nine& n) {
    constexpr std::size_t corners[4][4] = {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 7, 6}, {4, 5, 8, 7}};
    for (const auto& c : corners) {
      const std::array<std::uint32_t, 4> quad = {n[c[0]], n[c[1]], n[c[2]], n[c[3]]};
      const auto visible = std::count_if(quad.begin(), quad.end(),
                                         [&](std::uint32_t k) { return field.nodes[k].visible; });
      if (visible >= 3) field.quads.push_back(quad);
    }
  }

  // The cell whose first lattice point is (i, j).
  void cell(int i, int j, int depth) {
    const int half = 1 << (deepest(options) - depth);
    Nine nodes = {};
    int visible = 0;
    for (int k = 0; k < 9; ++k) {
      nodes[static_cast<std::size_t>(k)] = lattice.node(i + k % 3 * half, j + k / 3 * half);
      visible += field.nodes[nodes[static_cast<std::size_t>(k)]].visible ? 1 : 0;
    }
    if (visible == 0) return;
    if (half == 1 || !needs_refinement(nodes, depth, visible)) {
      leaf(nodes);
      return;
    }
    for (int k = 0; k < 4; ++k) cell(i + k % 2 * half, j + k / 2 * half, depth + 1);
  }
};

}  // namespace

View view_from_elevation(double elevation_deg) {
  const double e = elevation_deg * pi / 180;
  return {{std::cos(e), 0, std::sin(e)}, {0, 1, 0}, {-std::sin(e), 0, std::cos(e)}};
}

Eigen::Vector3d light_direction(double elevation_deg, double azimuth_deg) {
  const double v = elevation_deg * pi / 180, h = azimuth_deg * pi / 180;
  return {std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v)};
}

const PathExit* find_exit(const ExitField& field, std::uint32_t node, std::uint64_t signature) {
  const FieldNode& n = field.nodes[node];
  for (std::uint32_t k = 0; k < n.exit_count; ++k) {
    const PathExit& exit = field.exits[n.first_exit + k];
    if (exit.signature == signature) return &exit;
  }
  return nullptr;
}

ExitField trace_exit_field(const DropInstant& drop, const View& view, const ConeLights& lights,
                           const FieldOptions& options) {
  ExitField field;
  Lattice lattice{drop, view, options, field};
  const int depth = deepest(options);
  lattice.side = 2 * options.base_cells * (1 << depth) + 1;
  // The normal is tilted against the direction by at most atan(|grad h| / h): beyond this angle
  // from the view axis nothing faces the camera.
  const double smallest_h = std::max(0.2, 2 - drop.bound_h);
  lattice.reach =
      std::min(pi, pi / 2 + std::atan(drop.bound_slope / smallest_h)) + 2.0 / options.base_cells;
  lattice.e1 =
      std::cos(options.rotation_rad) * view.right + std::sin(options.rotation_rad) * view.up;
  lattice.e2 =
      std::cos(options.rotation_rad) * view.up - std::sin(options.rotation_rad) * view.right;
  lattice.index.assign(
      static_cast<std::size_t>(lattice.side) * static_cast<std::size_t>(lattice.side), no_node);
  Refiner refiner{lattice, lights, options, field};
  const int span = 2 << depth;
  for (int j = 0; j < options.base_cells; ++j) {
    for (int i = 0; i < options.base_cells; ++i) refiner.cell(i * span, j * span, 0);
  }
  return field;
}

}  // namespace pluvia
