// Smooth patches: the polynomial at any moment, cut up where a light's cone is.
#include <cmath>
#include <vector>

#include "raytrace/light_integrator.h"

namespace pluvia {

namespace {

constexpr int deepest_piece = 14;  // halvings, of either axis: a piece of 2^-7 of a cell

using DirectionNet = BezierNet<3>;

// Of the first three quantities: those of a node's direction, or of a direction alone.
template <std::size_t C>
double direction_length(const std::array<double, C>& d) {
  return std::sqrt(d[dir_x] * d[dir_x] + d[dir_y] * d[dir_y] + d[dir_z] * d[dir_z]);
}

// Largest second difference of a net along lines of the given stride; size() of an array of C.
template <std::size_t C, typename Size>
double second_difference(const BezierNet<C>& net, std::size_t stride, Size size) {
  double most = 0;
  for (std::size_t line = 0; line < 4; ++line) {
    const std::size_t n = line * (5 - stride);
    for (std::size_t k = 0; k < 2; ++k) {
      std::array<double, C> d;
      const auto &a = net[n + k * stride], &b = net[n + (k + 1) * stride],
                 &e = net[n + (k + 2) * stride];
      for (std::size_t c = 0; c < C; ++c) d[c] = a[c] - 2 * b[c] + e[c];
      most = std::max(most, size(d));
    }
  }
  return most;
}

// All of a patch at (u, v).
ConeVertex patch_point(const Patch& patch, double u, double v) {
  const auto bu = bernstein(u), bv = bernstein(v);
  std::array<double, 3> direction = {};
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t c = 0; c < 3; ++c) direction[c] += bu[i] * bv[j] * patch[4 * j + i][c];
    }
  }
  return patch_corner(patch, direction, u, v);
}

// A patch in one slice, cut up as finely as the lights in its reach need.
struct PatchCutter {
  Integrator& integrator;
  const Patch& patch;
  const Slice& slice;
  std::vector<int>& lights;  // a stack: the last entries are those of the piece at hand
  double flat = 0;           // what counts as flat for a direction
  // Of picture and throughput over the whole patch, over what is flat.
  double bend_u = 0, bend_v = 0;

  // Lights [first, end) of the stack reach the piece's parent.
  void piece(const DirectionNet& net, const Rectangle& r, int depth, std::size_t first) {
    const std::size_t end = lights.size();
    for (std::size_t k = first; k < end; ++k) {
      const int light = lights[k];
      if (!beyond_a_side(integrator.cones[static_cast<std::size_t>(light)], net)) {
        lights.push_back(light);
      }
    }
    if (lights.size() > end) cut(net, r, depth, end);
    lights.resize(end);
  }

  void cut(const DirectionNet& net, const Rectangle& r, int depth, std::size_t first) {
    const double du = r.u1 - r.u0, dv = r.v1 - r.v0;
    const double u_bend =
        std::max(chord_factor * second_difference(net, 1, direction_length<3>) / flat, bend_u * du * du);
    const double v_bend =
        std::max(chord_factor * second_difference(net, 4, direction_length<3>) / flat, bend_v * dv * dv);
    std::array<double, 3> twist;
    for (std::size_t c = 0; c < 3; ++c) twist[c] = net[0][c] - net[3][c] - net[12][c] + net[15][c];
    const double skew = 0.25 * direction_length(twist) / flat;
    if (depth >= deepest_piece || std::max({u_bend, v_bend, skew}) < 1) {
      leaf(net, r, first);
      return;
    }
    const bool along_u = u_bend > v_bend || (u_bend == v_bend && du >= dv);
    DirectionNet low, high;
    halve(net, along_u ? 1 : 4, low, high);
    const RectangleHalves halves = halves_of(r, along_u);
    piece(low, halves.low, depth + 1, first);
    piece(high, halves.high, depth + 1, first);
  }

  void leaf(const DirectionNet& net, const Rectangle& r, std::size_t first) {
    const std::array<ConeVertex, 4> corners = {
        patch_corner(patch, net[0], r.u0, r.v0), patch_corner(patch, net[3], r.u1, r.v0),
        patch_corner(patch, net[15], r.u1, r.v1), patch_corner(patch, net[12], r.u0, r.v1)};
    for (std::size_t k = first; k < lights.size(); ++k) {
      integrator.add_triangle(lights[k], slice, corners[0], corners[1], corners[2]);
      integrator.add_triangle(lights[k], slice, corners[0], corners[2], corners[3]);
    }
  }
};

}  // namespace

void integrate_smooth_patch(Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  const CellPolynomial<quantities> polynomial(field.times, [&](std::size_t place) {
    const std::uint32_t node = cell.nodes[place];
    return integrator.node_values(node, *find_exit(field, node, patch.signature));
  });
  std::vector<Eigen::Vector3d> hull;  // of the directions at any time
  for (int k = 0; k < polynomial.times; ++k) {
    for (const Node& p : polynomial.nets[static_cast<std::size_t>(k)]) {
      hull.emplace_back(p[dir_x], p[dir_y], p[dir_z]);
    }
  }
  std::vector<int> lights = integrator.lights_in_reach(hull);
  if (lights.empty()) return;
  const Motion motion = {
      .direction = polynomial.speed(direction_length<quantities>),
      .picture_px = polynomial.speed([](const Node& d) { return std::hypot(d[column], d[row]); })};
  for (const Slice& slice : integrator.slices(cell, motion, patch.importance)) {
    const Patch net = polynomial.at(slice.cell_share);
    if (std::all_of(net.begin(), net.end(), [](const Node& p) { return p[facing] < 0; })) continue;
    if (integrator.is_delta) {
      integrator.add_glints(lights, slice,
                            [&](double u, double v) { return patch_point(net, u, v); });
      continue;
    }
    PatchCutter cutter{.integrator = integrator, .patch = net, .slice = slice, .lights = lights};
    double brightest = least_light;
    for (const Node& p : net) brightest = std::max(brightest, p[light]);
    cutter.flat = integrator.flat_direction(patch.importance);
    const auto size = [&](const Node& d) {
      return std::max(std::hypot(d[column], d[row]) / integrator.flat_picture_px,
                      std::abs(d[light]) * patch.importance / (flat_share * brightest));
    };
    cutter.bend_u = chord_factor * second_difference(net, 1, size);
    cutter.bend_v = chord_factor * second_difference(net, 4, size);
    DirectionNet directions;
    for (std::size_t n = 0; n < 16; ++n) {
      directions[n] = {net[n][dir_x], net[n][dir_y], net[n][dir_z]};
    }
    cutter.piece(directions, {}, 0, 0);
  }
}

}  // namespace pluvia
