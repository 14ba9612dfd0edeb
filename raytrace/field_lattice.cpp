#include "raytrace/field_lattice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "raytrace/wide_intersect.h"
#include "raytrace/wide_paths.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// How far beyond the outline maps are continued. Reflectance grows without bound there (it has a
// pole at minus the cosine of Brewster's angle, -0.6), and a cubic cannot follow.
constexpr double least_facing = -0.35;

// For other indices the exits end where reflectance has grown as much as there: its logarithm's
// slope at the outline is -4 n^2 / sqrt(n^2 - 1) for p, so that is at -0.71 sqrt(n^2 - 1) / n^2. An
// index of 1 has no such place: its cells at the outline hold only the nodes that the camera sees.
double least_facing_of_exits(double refractive_index) {
  const double n2 = refractive_index * refractive_index;
  return std::max(least_facing, -0.71 * std::sqrt(n2 - 1) / n2);
}

// Of a place from the star centre; zero beyond the map's edge.
Eigen::Vector3d direction_of(const FieldLattice& lattice, const LatticePlace& place) {
  const double reach = lattice.reach_rad;
  const double shift = lattice.options.shift * 2 * reach / lattice.options.base_cells;
  const double x = -reach + lattice.step_rad() * place.i + shift;
  const double y = -reach + lattice.step_rad() * place.j + shift;
  const double r = std::hypot(x, y);
  if (r >= pi) return {0, 0, 0};
  const double sinc = r > 1e-9 ? std::sin(r) / r : 1;
  return std::cos(r) * lattice.view.to_camera + sinc * (x * lattice.e1 + y * lattice.e2);
}

void take_exits(ExitField& field, const HitExits& traced,
                const std::vector<std::uint32_t>& numbers) {
  const auto before = static_cast<std::uint32_t>(field.exits.size());
  field.exits.insert(field.exits.end(), traced.exits.begin(), traced.exits.end());
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    FieldNode& node = field.nodes[numbers[n]];
    node.first_exit = before + traced.first_exit[n];
    node.exit_count = traced.first_exit[n + 1] - traced.first_exit[n];
    if (node.facing <= 0) continue;
    for (std::uint32_t e = 0; e < node.exit_count; ++e)
      node.throughput += field.exits[node.first_exit + e].throughput;
    ++field.traced_nodes;
  }
  field.remainder.beyond_order += traced.remainder.beyond_order;
  field.remainder.given_up += traced.remainder.given_up;
  field.remainder.lost += traced.remainder.lost;
}

void trace_nodes(FieldLattice& lattice, const DropInstant& drop,
                 const std::vector<AskedNode>& asked) {
  const View& view = lattice.view;
  const FieldOptions& options = lattice.options;
  std::vector<Eigen::Vector3d> directions;
  std::vector<std::uint32_t> numbers;
  for (const AskedNode& node : asked) {
    if (node.direction.isZero()) continue;
    directions.push_back(node.direction);
    numbers.push_back(node.number);
  }
  const auto points = surface_points_of(drop, directions, view.to_camera, options.isa);
  const double least_of_exits = least_facing_of_exits(options.paths.refractive_index);
  std::vector<CameraHit> hits;
  std::size_t followed = 0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const SurfacePoint& point = points[n];
    FieldNode& node = lattice.field.nodes[numbers[n]];
    node.facing = point.normal.dot(view.to_camera);
    if (node.facing < least_facing || (node.facing > 0 && point.hidden)) continue;
    node.known = true;
    node.xy_m = {point.position_m.dot(view.right), point.position_m.dot(view.up)};
    if (node.facing <= 0) {
      node.throughput = 1;  // at the outline all light is reflected
      if (node.facing <= least_of_exits) continue;
    }
    hits.push_back({point.position_m, point.normal});
    numbers[followed++] = numbers[n];
  }
  numbers.resize(followed);
  take_exits(lattice.field, trace_exits_of(drop, hits, view.to_camera, options.paths, options.isa),
             numbers);
}

// How far from the view axis something may face the camera: the normal is tilted against the
// direction by at most atan(|grad h| / h).
double reach_of(const std::vector<DropInstant>& drops) {
  double slope = 0, bound = 0;
  for (const DropInstant& drop : drops) {
    slope = std::max(slope, drop.bound_slope);
    bound = std::max(bound, drop.bound_h);
  }
  const double smallest_h = std::max(0.2, 2 - bound);
  return std::min(pi, pi / 2 + std::atan(slope / smallest_h));
}

}  // namespace

FieldLattice make_field_lattice(std::vector<DropInstant> drops, const View& view,
                                const FieldOptions& options, ExitField& field) {
  FieldLattice lattice = {
      .view = view, .options = options, .field = field, .drops = std::move(drops)};
  lattice.asked.resize(lattice.drops.size());
  // The map may be shifted by half a cell.
  lattice.reach_rad = reach_of(lattice.drops) * (1 + 1.0 / options.base_cells);
  lattice.side = options.base_cells * (cell_side - 1) * (1 << options.space_depth);
  const double c = std::cos(options.rotation_rad), s = std::sin(options.rotation_rad);
  lattice.e1 = c * view.right + s * view.up;
  lattice.e2 = c * view.up - s * view.right;
  return lattice;
}

std::uint32_t ask_node(FieldLattice& lattice, const LatticePlace& place) {
  const auto number = static_cast<std::uint32_t>(lattice.index.size());
  const auto [slot, is_new] = lattice.index.try_emplace(place.key(), number);
  if (is_new)
    lattice.asked[static_cast<std::size_t>(place.k)].push_back(
        {number, direction_of(lattice, place)});
  return slot->second;
}

void trace_asked(FieldLattice& lattice) {
  lattice.field.nodes.resize(lattice.index.size());
  for (std::size_t k = 0; k < lattice.asked.size(); ++k) {
    trace_nodes(lattice, lattice.drops[k], lattice.asked[k]);
    lattice.asked[k].clear();
  }
}

}  // namespace pluvia
