// All that the camera sees: environments, coverage and other values of the surface.
#include "raytrace/loose_triangles.h"

namespace pluvia {

namespace {

// What the camera gets from the surface, and where its planes are.
struct Surface {
  Integrator& integrator;
  const EnvironmentRequest& environment;
  ValueDeposit many;
  std::vector<double> none = {};  // as many zeros

  int uniform_plane() const { return static_cast<int>(integrator.cones.size()); }
  int coverage_plane() const { return uniform_plane() + (environment.uniform ? 1 : 0); }
};

// Environment and coverage of a cell of the surface.
struct SurfaceCell {
  Surface& surface;
  Integrator& integrator;
  const FieldCell& cell;
  CellValues other = {};  // of the environments that are not uniform

  SurfaceCell(Surface& on_surface, const FieldCell& at_cell)
      : surface(on_surface), integrator(on_surface.integrator), cell(at_cell) {
    if (surface.many.count > 0) other = cell_values(integrator.field, cell, surface.environment);
  }

  // dir_x holds the place: no direction is asked for here, and the place's other values are.
  Node values(std::size_t node) const {
    const std::uint32_t n = cell.nodes[node];
    Node v = integrator.node_values(n, {});
    v[dir_x] = static_cast<double>(node % 16);
    v[light] = integrator.field.nodes[n].throughput;
    return v;
  }

  void add(const Slice& slice, const ValueRows& rows, const ConeVertex& a, const ConeVertex& b,
           const ConeVertex& c) const {
    ConePolygon polygon;
    polygon.count = 3;
    const std::array<ConeVertex, 3> corners = {a, b, c};
    std::array<const double*, 3> others = {};
    for (std::size_t k = 0; k < 3; ++k) {
      ConeVertex& v = polygon.vertices[k] = corners[k];
      if (rows.size() > 0) {
        // No light where the polynomial falls below zero, as clip_to_facing() has it.
        others[k] = v.throughput < 0 ? surface.none.data()
                                     : rows.row(static_cast<Eigen::Index>(v.dx)).data();
      }
      v.dx = k == 0 ? 1 : 0;
      v.dy = k == 1 ? 1 : 0;
      v.dz = k == 2 ? 1 : 0;
    }
    clip_to_facing(polygon);
    if (surface.environment.uniform) {
      deposit(integrator.window, surface.uniform_plane(), slice.travel, polygon, slice.time_share);
    }
    if (rows.size() > 0) surface.many.add(slice.travel, polygon, slice.time_share, others);
    for (int k = 0; k < polygon.count; ++k) {
      polygon.vertices[static_cast<std::size_t>(k)].throughput = 1;
    }
    deposit(integrator.window, surface.coverage_plane(), slice.travel, polygon, slice.time_share);
  }

  // Twice as fine as the nodes where the outline passes: a chord's bulge shrinks to a quarter.
  void add_whole(const CellPolynomial<quantities>& polynomial, bool at_outline,
                 const Slice& slice) const {
    const double share = slice.cell_share;
    const Patch net = polynomial.at(share);
    const std::size_t steps = (cell_side - 1) * (at_outline ? 2 : 1);
    ValueRows rows;
    if (surface.many.count > 0) rows = other.grid(share, steps);
    std::array<std::array<ConeVertex, 2 * cell_side - 1>, 2 * cell_side - 1> grid;
    for (std::size_t j = 0; j <= steps; ++j) {
      for (std::size_t i = 0; i <= steps; ++i) {
        const double place = static_cast<double>((steps + 1) * j + i);
        grid[j][i] =
            patch_corner(net, {place, 0, 0}, static_cast<double>(i) / static_cast<double>(steps),
                         static_cast<double>(j) / static_cast<double>(steps));
      }
    }
    for (std::size_t j = 0; j < steps; ++j) {
      for (std::size_t i = 0; i < steps; ++i) {
        add(slice, rows, grid[j][i], grid[j][i + 1], grid[j + 1][i + 1]);
        add(slice, rows, grid[j][i], grid[j + 1][i + 1], grid[j + 1][i]);
      }
    }
  }

  void add_loose(const Slice& slice) const {
    const ExitField& field = integrator.field;
    const auto node_at = [&](std::size_t time, std::size_t place) -> std::optional<Node> {
      if (!field.nodes[cell.nodes[16 * time + place]].known) return std::nullopt;
      return values(16 * time + place);
    };
    const BetweenNodes t = between_nodes(field, slice.cell_share);
    ValueRows rows;
    if (surface.many.count > 0) rows = other.loose(field, cell, t.before, t.share);
    for_loose_triangles(t, field.times, node_at,
                        [&](const ConeVertex& a, const ConeVertex& b, const ConeVertex& c) {
                          add(slice, rows, a, b, c);
                        });
  }

  void integrate() const {
    const auto count = static_cast<std::size_t>(16 * integrator.field.times);
    bool whole = true, behind = false;
    for (std::size_t n = 0; n < count; ++n) {
      const FieldNode& node = integrator.field.nodes[cell.nodes[n]];
      whole = whole && node.known;
      behind = behind || node.facing <= 0;
    }
    const bool has_values = surface.many.count > 0;
    if (!whole) {
      for (const Slice& slice :
           integrator.surface_slices(cell, node_motion_px(integrator, cell), has_values)) {
        add_loose(slice);
      }
      return;
    }
    const CellPolynomial<quantities> polynomial(integrator.field.times,
                                                [&](std::size_t place) { return values(place); });
    const double motion_px =
        polynomial.speed([](const Node& d) { return std::hypot(d[column], d[row]); });
    for (const Slice& slice : integrator.surface_slices(cell, motion_px, has_values)) {
      add_whole(polynomial, behind, slice);
    }
  }
};

}  // namespace

void integrate_surfaces(Integrator& integrator, const EnvironmentRequest& environment) {
  Surface surface{.integrator = integrator,
                  .environment = environment,
                  .many = make_value_deposit(integrator.window, value_count(environment)),
                  .none = std::vector<double>(value_count(environment))};
  for (const std::uint32_t cell : integrator.field.surfaces) {
    SurfaceCell(surface, integrator.field.cells[cell]).integrate();
  }
  surface.many.add_to(integrator.window, surface.coverage_plane() + 1);
}

}  // namespace pluvia
