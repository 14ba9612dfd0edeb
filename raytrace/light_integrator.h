// Inside of raytrace/light_integral.h: what the kinds of patches share, and each kind's way into
// the pictures.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "raytrace/bezier_patch.h"
#include "raytrace/glints.h"
#include "raytrace/light_integral.h"

namespace pluvia {

// A piece of a patch is cut into two triangles when it bends by less than this share of the cone,
// and of its light (both over its importance), and this much of a pixel.
constexpr double flat_share = 0.02;
constexpr double flat_px = 0.05;
constexpr double flat_radii = 0.004;  // .. or of the drop's radius, where pixels are coarser

// No patch is thought to have less light than this, when bends of its light are weighed.
constexpr double least_light = 0.002;

// What a patch holds at its nodes, or control points.
enum : std::size_t { dir_x, dir_y, dir_z, column, row, light, facing, quantities };
using Node = std::array<double, quantities>;
using Patch = BezierNet<quantities>;

struct Rectangle {
  double u0 = 0, u1 = 1, v0 = 0, v1 = 1;
};

struct RectangleHalves {
  Rectangle low = {}, high = {};
};

inline RectangleHalves halves_of(const Rectangle& r, bool along_u) {
  RectangleHalves halves = {r, r};
  if (along_u) {
    halves.low.u1 = halves.high.u0 = 0.5 * (r.u0 + r.u1);
  } else {
    halves.low.v1 = halves.high.v0 = 0.5 * (r.v0 + r.v1);
  }
  return halves;
}

// A bound on the distance between a curve and its chord, from its control points: n (n - 1) / 8
// times their largest second difference, n = 3.
constexpr double chord_factor = 0.75;

// True when all directions are beyond one side of the cone, by more than `slack`: so is everything
// between them. The side that the first of them is farthest beyond is tried first.
template <typename Directions>
bool beyond_a_side(const Cone& cone, const Directions& directions, double slack = 0) {
  const auto height = [](const Eigen::Vector3d& n, const auto& d) {
    return n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
  };
  const auto all_beyond = [&](const Eigen::Vector3d& n) {
    return std::all_of(std::begin(directions), std::end(directions),
                       [&](const auto& d) { return height(n, d) < -slack; });
  };
  std::array<double, cone_sides> heights;
  for (std::size_t k = 0; k < cone_sides; ++k) {
    heights[k] = height(cone.inward[k], *std::begin(directions));
  }
  const auto lowest = std::min_element(heights.begin(), heights.end());
  if (*lowest >= -slack) return false;
  if (all_beyond(cone.inward[static_cast<std::size_t>(lowest - heights.begin())])) return true;
  for (std::size_t k = 0; k < cone_sides; ++k) {
    if (heights[k] < -slack && all_beyond(cone.inward[k])) return true;
  }
  return false;
}

// A slice of a cell's time.
struct Slice {
  double cell_share = 0;  // its middle, as a share of the cell's time
  double span_share = 0;  // .. of the span's
  Travel travel = {};
  double time_share = 0;  // of the whole exposure
};

// How far a patch's map moves in its cell's time.
struct Motion {
  double direction = 0;
  double picture_px = 0;
};

struct Integrator {
  const ExitField& field;
  const StreakFrame& frame;
  const SpanSlices& span;
  StreakWindow& window;
  std::vector<Cone> cones = {};
  double weight = 0;  // of a light's polygon: 1 / (pi sin^2 half_angle)
  double flat_picture_px = flat_px;
  bool is_delta = false;       // the lights are points at infinity
  double slice_direction = 0;  // how far a direction may move in a slice; 0: `most` slices

  Node node_values(std::uint32_t index, const PathExit& exit) const;

  std::vector<Slice> slices(const FieldCell& cell, const Motion& motion, double importance) const;
  std::vector<Slice> surface_slices(const FieldCell& cell, double motion_px,
                                    bool has_other_values) const;

  // Lights that one of the directions, or what is between them, may reach.
  std::vector<int> lights_in_reach(const std::vector<Eigen::Vector3d>& directions) const;

  // What counts as flat for directions: a share of the cone, more for a patch of less importance.
  double flat_direction(double importance) const;

  void add_triangle(int light, const Slice& slice, const ConeVertex& a, const ConeVertex& b,
                    const ConeVertex& c);
  void add_glints(const std::vector<int>& lights, const Slice& slice, const PatchMap& map);
  void add_glint(int light, const Slice& slice, const Glint& glint);
};

// The polynomial through a cell's nodes, by its control points in space and time.
template <std::size_t C>
struct CellPolynomial {
  int times = 1;
  std::array<BezierNet<C>, cell_side> nets = {};

  template <typename NodeAt>  // node_at(place in the cell)
  CellPolynomial(int node_times, NodeAt node_at) : times(node_times) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(times); ++k) {
      for (std::size_t n = 0; n < 16; ++n) nets[k][n] = node_at(16 * k + n);
      to_control_points(nets[k]);
    }
    if (times == 1) return;
    for (std::size_t n = 0; n < 16; ++n) {
      to_control_points(nets[0][n], nets[1][n], nets[2][n], nets[3][n]);
    }
  }

  // Control points in space at a share of the cell's time.
  BezierNet<C> at(double share) const {
    if (times == 1) return nets[0];
    const auto b = bernstein(share);
    BezierNet<C> net;
    for (std::size_t n = 0; n < 16; ++n) {
      for (std::size_t c = 0; c < C; ++c) {
        net[n][c] = b[0] * nets[0][n][c] + b[1] * nets[1][n][c] + b[2] * nets[2][n][c] +
                    b[3] * nets[3][n][c];
      }
    }
    return net;
  }

  // A bound on the speed of some of the quantities, per cell's time: a cubic's derivative is 3
  // times the differences of its control points, or between them.
  template <typename Size>  // size(difference of two control points)
  double speed(Size size) const {
    double most = 0;
    for (std::size_t k = 0; k + 1 < static_cast<std::size_t>(times); ++k) {
      for (std::size_t n = 0; n < 16; ++n) {
        std::array<double, C> d;
        for (std::size_t c = 0; c < C; ++c) d[c] = 3 * (nets[k + 1][n][c] - nets[k][n][c]);
        most = std::max(most, size(d));
      }
    }
    return most;
  }
};

// Picture, throughput and facing of a patch at (u, v).
ConeVertex patch_corner(const Patch& patch, const std::array<double, 3>& direction, double u,
                        double v);

// Directions of a patch's nodes.
std::vector<Eigen::Vector3d> node_directions(const ExitField& field, const FieldPatch& patch);

// How far a cell's nodes move in the picture, at most.
double node_motion_px(const Integrator& integrator, const FieldCell& cell);

// .. and how far the directions there.
Motion node_motion(const Integrator& integrator, const FieldPatch& patch);

void integrate_smooth_patch(Integrator& integrator, const FieldPatch& patch);
void integrate_edge_patch(Integrator& integrator, const FieldPatch& patch);
void integrate_loose_patch(Integrator& integrator, const FieldPatch& patch);

// Environment, coverage and other values of all that the camera sees.
void integrate_surfaces(Integrator& integrator, const EnvironmentRequest& environment);

}  // namespace pluvia
