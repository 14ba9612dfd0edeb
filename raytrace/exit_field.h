// The exit-direction field of a drop at one instant, seen from one direction: the map from a point
// of the visible surface to the directions from which light would reach the camera there, one map
// per path signature. It does not depend on the light: traced once, it serves every light and any
// environment (raytrace/light_integral.h).
//
// The surface is parametrised by its direction from the star centre, u = cos r c + sin r (x e1 + y
// e2) / r, c toward the camera, r = |(x, y)|: smooth across the silhouette, and a square of that
// map carries little projected area where it grazes. Square cells of 3 x 3 nodes are refined where
// a map bends or breaks (silhouette, total reflection, shadow) near one of the cones asked for;
// where no light looks, the field stays coarse.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/exit_paths.h"

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
  double half_angle_rad = 0;                     // of every cone, > 0 and < pi / 4
};

struct FieldOptions {
  PathOptions paths = {};
  int base_cells = 16;       // per side of the square map
  int bend_depth = 2;        // halvings of a cell at most, where a light looks: a map bends
  int break_depth = 3;       // .. where a map breaks off (total reflection, shadow, silhouette)
  int silhouette_depth = 2;  // .. at the outline, light or not: for the projected area
  // A cell is flat when its middles lie within this share of the cone of the mean of their ends
  // (the leaf's own triangles are four times flatter).
  double bend_tolerance = 0.25;
  // Of the map about the view axis, and its shift in cells: dithering them from instant to instant
  // turns grid error into noise that averages out.
  double rotation_rad = 0;
  double shift = 0;
};

struct FieldNode {
  Eigen::Vector2d xy_m = {0, 0};  // position to the right and up, relative to the drop's origin
  bool visible = false;
  std::uint32_t first_exit = 0, exit_count = 0;
  double throughput = 0;  // of all exits together
};

struct ExitField {
  std::vector<FieldNode> nodes = {};
  std::vector<PathExit> exits = {};
  std::vector<std::array<std::uint32_t, 4>> quads = {};  // leaves; at least 3 visible corners each
  PathRemainder remainder = {};                          // sums over nodes
  std::size_t traced_nodes = 0;
};

// The exit of a node with that signature, or nullptr.
const PathExit* find_exit(const ExitField& field, std::uint32_t node, std::uint64_t signature);

ExitField trace_exit_field(const DropInstant& drop, const View& view, const ConeLights& lights,
                           const FieldOptions& options);

}  // namespace pluvia
