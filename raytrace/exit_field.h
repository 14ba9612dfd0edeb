// The exit-direction field of a drop over a span of time, seen from one direction: the map from a
// point of the visible surface and a time to the directions from which light would reach the camera
// there, one map per path signature. It does not depend on the light: traced once, it serves every
// light and any environment (raytrace/light_integral.h).
//
// The surface is parametrised by its direction from the star centre, u = cos r c + sin r (x e1 + y
// e2) / r, c toward the camera, r = |(x, y)|: smooth across the outline, and a square of that map
// carries little projected area where it grazes. A cell is a block of 4 x 4 nodes in (x, y) at 4
// times: where a map is smooth, the tricubic polynomial through them is the map at ANY time of the
// span, so that the streak may be integrated over far more moments than were traced. Where only the
// last interface spoils that (total reflection sets in), what meets the interface is interpolated,
// and the law of refraction applied at each point. A cell is halved in space or in time, for the
// sake of those paths that bend or break in it (total reflection, shadow) near one of the lights;
// where no light looks, the field stays coarse.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/exit_paths.h"
#include "raytrace/isa.h"

namespace pluvia {

// What the camera sees: unit vectors in the drop frame. right = z x (horizontal part of to_camera).
struct View {
  Eigen::Vector3d to_camera = {1, 0, 0};
  Eigen::Vector3d right = {0, 1, 0};
  Eigen::Vector3d up = {0, 0, 1};
};

// elevation in -90..90 degrees; the camera stands at azimuth 0 (+x).
View view_from_elevation(double elevation_deg);

// Unit vector toward a light (raytrace axes: (cos v cos h, cos v sin h, sin v)).
Eigen::Vector3d light_direction(double elevation_deg, double azimuth_deg);

struct ConeLights {
  std::vector<Eigen::Vector3d> directions = {};  // unit, toward the lights
  double half_angle_rad = 0;  // of every cone, > 0 and < pi / 4; integrate_lights takes 0, too
};

struct FieldOptions {
  PathOptions paths = {};
  int base_cells = 12;  // per side of the square map
  int space_depth = 3;  // halvings of a cell's sides at most
  int time_depth = 2;   // halvings of a cell's time at most
  // A map is smooth in a cell when its third differences are below this share of the cone's half
  // angle (over its importance, FieldPatch): what the cubic itself leaves out is smaller still by
  // the ratio of fourth to third differences.
  double bend_tolerance = 0.3;
  Isa isa = best_isa();  // that the paths are traced with
  // Of the map about the view axis, and its shift in cells: dithering them from span to span turns
  // grid error into noise that averages out.
  double rotation_rad = 0;
  double shift = 0;
};

struct TimeSpan {
  double first_s = 0, last_s = 0;
};

// A surface point at one of the field's times. Known: the camera sees it, or it lies beyond the
// outline (facing < 0), where its exits continue the map (exit_paths.h). Not known: hidden behind
// another part of the drop, or far beyond the outline.
struct FieldNode {
  Eigen::Vector2d xy_m = {0, 0};  // position to the right and up, relative to the drop's origin
  double facing = 0;              // normal . to_camera
  bool known = false;
  std::uint32_t first_exit = 0, exit_count = 0;
  double throughput = 0;  // of all exits together; 1 beyond the outline
};

constexpr int cell_side = 4;  // nodes per side, in space and (unless the field is one instant) time

struct FieldCell {
  std::array<std::uint32_t, cell_side* cell_side* cell_side> nodes = {};  // x fastest, then y
  double first = 0, last = 1;  // of the cell's time, as shares of the span
};

// How far a path's map in a cell is to be trusted between the nodes.
enum class PatchKind {
  smooth,  // the polynomial through its directions and throughputs is the map
  edge,    // .. through what meets its last interface (PathExit): the map has a fold-like edge
           // where that interface turns to total reflection, or grazes
  loose    // the depth ran out: only the nodes are to be trusted
};

struct FieldPatch {  // one path's map in one cell
  std::uint32_t cell = 0;
  std::uint64_t signature = 0;
  PatchKind kind = PatchKind::smooth;
  // Less than 1 where the path is faint and gives but a small part of any light's light; at least
  // least_importance. What it may err by grows as 1 / importance.
  double importance = 1;
};

constexpr double least_importance = 0.02;

struct ExitField {
  double refractive_index = 1.333;
  double radius_m = 0;  // the drop's scale
  int times = 1;  // nodes of a cell in time: 1 for one instant, or a drop that is rigid; else 4
  std::vector<FieldNode> nodes = {};
  std::vector<PathExit> exits = {};
  std::vector<FieldCell> cells = {};
  std::vector<FieldPatch> patches = {};      // the maps near lights
  std::vector<std::uint32_t> surfaces = {};  // cells that tile what the camera sees
  PathRemainder remainder = {};              // sums over the nodes that the camera sees
  std::size_t traced_nodes = 0;              // those nodes
};

// The exit of a node with that signature, or nullptr.
const PathExit* find_exit(const ExitField& field, std::uint32_t node, std::uint64_t signature);

// The field over a span of time. 1 <= base_cells, depths >= 0. The memory of `storage`, a field no
// longer needed, is used again.
ExitField trace_exit_field(const DropShape& drop, const TimeSpan& span, const View& view,
                           const ConeLights& lights, const FieldOptions& options,
                           ExitField storage = {});

// The field of one instant.
ExitField trace_exit_field(const DropInstant& drop, const View& view, const ConeLights& lights,
                           const FieldOptions& options);

}  // namespace pluvia
