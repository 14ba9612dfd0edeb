#include "raytrace/light_integrator.h"

#include <cmath>

namespace pluvia {

namespace {

// Pieces' directions stay within a fifth of the cone, however faint the patch.
constexpr double least_flat_importance = 0.1;

constexpr double glint_px = 1e-3;  // what the glint of a delta light covers of the picture

// How far the surface may move in a slice, over what directions may of the cone's half angle: in
// pixels, for a path's picture and for the surface's own.
constexpr double slice_motion_px = 1;
constexpr double surface_motion_px = 0.4;

// Other values of the surface follow the exits' directions, not its motion alone.
constexpr double slices_per_value_slice = 4;

// Slices of a cell's time: as many as asked for, at most its share of the span's. A tolerance keeps
// a share that is whole from being rounded up.
std::vector<Slice> slices_of(const SpanSlices& span, const FieldCell& cell, double asked) {
  const double share = cell.last - cell.first;
  const int most = std::max(1, static_cast<int>(std::ceil(span.most * share - 1e-9)));
  const int count = asked < most ? std::max(1, static_cast<int>(std::ceil(asked))) : most;
  const double rows = span.travel.last_row - span.travel.first_row;
  const auto start = [&](int k) {  // of slice k, as a share of the cell's time
    return std::clamp((k - (span.shifted ? 0.5 : 0)) / count, 0.0, 1.0);
  };
  std::vector<Slice> slices;
  for (int k = 0; k < count + (span.shifted ? 1 : 0); ++k) {
    const double from = cell.first + share * start(k), to = cell.first + share * start(k + 1);
    slices.push_back(
        {.cell_share = 0.5 * (start(k) + start(k + 1)),
         .span_share = 0.5 * (from + to),
         .travel = {span.travel.first_row + rows * from, span.travel.first_row + rows * to},
         .time_share = span.time_share * (to - from)});
  }
  return slices;
}

}  // namespace

Node Integrator::node_values(std::uint32_t index, const PathExit& exit) const {
  const FieldNode& n = field.nodes[index];
  return {exit.direction.x(),
          exit.direction.y(),
          exit.direction.z(),
          frame.centre_column + n.xy_m.x() / frame.pixel_m,
          -n.xy_m.y() / frame.pixel_m,
          exit.throughput,
          n.facing};
}

std::vector<Slice> Integrator::slices(const FieldCell& cell, const Motion& motion,
                                      double importance) const {
  if (slice_direction == 0) return slices_of(span, cell, span.most);
  return slices_of(span, cell,
                   std::max(motion.direction * importance / slice_direction,
                            motion.picture_px / (slice_motion_px * span.motion_tolerance)));
}

std::vector<Slice> Integrator::surface_slices(const FieldCell& cell, double motion_px,
                                              bool has_other_values) const {
  if (span.motion_tolerance == 0) return slices_of(span, cell, span.most);
  const double asked = motion_px / (surface_motion_px * span.motion_tolerance);
  const double share = cell.last - cell.first;
  return slices_of(
      span, cell,
      has_other_values ? std::max(asked, span.most * share / slices_per_value_slice) : asked);
}

std::vector<int> Integrator::lights_in_reach(const std::vector<Eigen::Vector3d>& directions) const {
  std::vector<int> found;
  for (std::size_t l = 0; l < cones.size(); ++l) {
    if (!beyond_a_side(cones[l], directions)) found.push_back(static_cast<int>(l));
  }
  return found;
}

double Integrator::flat_direction(double importance) const {
  return flat_share * std::tan(cones.front().half_angle_rad) /
         std::max(importance, least_flat_importance);
}

void Integrator::add_triangle(int light, const Slice& slice, const ConeVertex& a,
                              const ConeVertex& b, const ConeVertex& c) {
  const Cone& cone = cones[static_cast<std::size_t>(light)];
  if (is_delta) {
    if (const auto glint = glint_in_triangle(cone.axis, a, b, c)) add_glint(light, slice, *glint);
    return;
  }
  const auto direction = [](const ConeVertex& v) { return std::array{v.dx, v.dy, v.dz}; };
  if (beyond_a_side(cone, std::array{direction(a), direction(b), direction(c)})) return;
  ConePolygon polygon;
  polygon.vertices[0] = a;
  polygon.vertices[1] = b;
  polygon.vertices[2] = c;
  polygon.count = 3;
  clip_to_facing(polygon);
  clip_to_margin(polygon);
  clip_to_cone(cone, polygon);
  deposit(window, light, slice.travel, polygon, slice.time_share * weight);
}

void Integrator::add_glints(const std::vector<int>& lights, const Slice& slice,
                            const PatchMap& map) {
  std::vector<Eigen::Vector3d> directions;
  for (const int light : lights) {
    directions.push_back(cones[static_cast<std::size_t>(light)].axis);
  }
  find_glints(map, directions,
              [&](std::size_t k, const Glint& glint) { add_glint(lights[k], slice, glint); });
}

// As a square: its sides share it out between pixels that meet in it.
void Integrator::add_glint(int light, const Slice& slice, const Glint& glint) {
  ConePolygon square;
  square.count = 4;
  for (std::size_t k = 0; k < 4; ++k) {
    const double x = k == 1 || k == 2 ? 0.5 : -0.5, y = k >= 2 ? 0.5 : -0.5;
    square.vertices[k] = {0, 0, 0, glint.x + x * glint_px, glint.y + y * glint_px, 1, 1, 1};
  }
  deposit(window, light, slice.travel, square,
          slice.time_share * glint.light / (glint_px * glint_px));
}

ConeVertex patch_corner(const Patch& patch, const std::array<double, 3>& direction, double u,
                        double v) {
  const auto bu = bernstein(u), bv = bernstein(v);
  std::array<double, 4> sum = {};
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double w = bu[i] * bv[j];
      for (std::size_t c = 0; c < 4; ++c) sum[c] += w * patch[4 * j + i][column + c];
    }
  }
  return {direction[0], direction[1], direction[2], sum[0], sum[1], sum[2], sum[3], 1};
}

std::vector<Eigen::Vector3d> node_directions(const ExitField& field, const FieldPatch& patch) {
  std::vector<Eigen::Vector3d> directions;
  for (int n = 0; n < 16 * field.times; ++n) {
    const std::uint32_t node = field.cells[patch.cell].nodes[static_cast<std::size_t>(n)];
    if (const PathExit* exit = find_exit(field, node, patch.signature)) {
      directions.push_back(exit->direction);
    }
  }
  return directions;
}

double node_motion_px(const Integrator& integrator, const FieldCell& cell) {
  const ExitField& field = integrator.field;
  double most_m = 0;
  for (std::size_t n = 0; n + 16 < static_cast<std::size_t>(16 * field.times); ++n) {
    const FieldNode &before = field.nodes[cell.nodes[n]], &after = field.nodes[cell.nodes[n + 16]];
    if (!before.known || !after.known) continue;
    most_m = std::max(most_m, (cell_side - 1) * (after.xy_m - before.xy_m).norm());
  }
  return most_m / integrator.frame.pixel_m;
}

Motion node_motion(const Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  Motion most = {.picture_px = node_motion_px(integrator, cell)};
  for (std::size_t n = 0; n + 16 < static_cast<std::size_t>(16 * field.times); ++n) {
    const PathExit* before = find_exit(field, cell.nodes[n], patch.signature);
    const PathExit* after = find_exit(field, cell.nodes[n + 16], patch.signature);
    if (!before || !after) continue;
    most.direction =
        std::max(most.direction, (cell_side - 1) * (after->direction - before->direction).norm());
  }
  return most;
}

}  // namespace pluvia
