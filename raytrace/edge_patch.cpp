// Edge patches: what meets the last interface is the polynomial, what leaves it is computed at each
// point.
#include <cmath>
#include <vector>

#include "raytrace/light_integrator.h"

namespace pluvia {

namespace {

// What an edge patch holds at its nodes: the beam that meets the last interface, and the picture.
enum : std::size_t {
  incident_x,
  incident_y,
  incident_z,
  normal_x,
  normal_y,
  normal_z,
  part_s,
  part_p,
  edge_column,
  edge_row,
  edge_facing,
  edge_quantities
};
using EdgeNet = BezierNet<edge_quantities>;

// A patch whose map has an edge where the last interface turns to total reflection: what meets that
// interface is the polynomial, what leaves it is computed at each point. Pieces are sampled at 3 x
// 3 points, and halved where a light may reach them until they are flat.
struct EdgeCutter {
  Integrator& integrator;
  const EdgeNet& net;
  const Slice& slice;
  bool refracted = true;
  double importance = 1;
  std::vector<int>& lights;  // a stack: the last entries are those of the piece at hand
  double flat = 0;
  double brightest = least_light;  // of the whole patch

  using Samples = std::array<ConeVertex, 9>;  // u fastest
  static constexpr int deepest = 12;          // halvings, of either axis

  using Quantities = std::array<double, edge_quantities>;

  ConeVertex vertex(const Quantities& q) const {
    const InterfaceExit exit =
        leave_interface(refracted, {q[incident_x], q[incident_y], q[incident_z]},
                        {q[normal_x], q[normal_y], q[normal_z]}, q[part_s], q[part_p],
                        integrator.field.refractive_index);
    return {exit.direction.x(), exit.direction.y(), exit.direction.z(), q[edge_column],
            q[edge_row],        exit.throughput,    q[edge_facing],     exit.margin};
  }

  ConeVertex point(double u, double v) const {
    const auto bu = bernstein(u), bv = bernstein(v);
    Quantities q = {};
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t c = 0; c < edge_quantities; ++c) q[c] += bu[i] * bv[j] * net[4 * j + i][c];
      }
    }
    return vertex(q);
  }

  // At a piece's corners, middles of sides and middle.
  Samples samples(const Rectangle& r) const {
    Samples s;
    for (std::size_t k = 0; k < 3; ++k) put_line(r, k, true, s);
    return s;
  }

  // The three samples of the piece's row (v constant) or column k.
  void put_line(const Rectangle& r, std::size_t k, bool is_row, Samples& s) const {
    const double u[3] = {r.u0, 0.5 * (r.u0 + r.u1), r.u1}, v[3] = {r.v0, 0.5 * (r.v0 + r.v1), r.v1};
    const std::size_t across = is_row ? 1 : 4, along = is_row ? 4 : 1;  // of the net
    const auto b = bernstein(is_row ? v[k] : u[k]);
    std::array<Quantities, 4> line;  // control points there
    for (std::size_t i = 0; i < 4; ++i) {
      const Quantities* p = &net[i * across];
      for (std::size_t c = 0; c < edge_quantities; ++c) {
        line[i][c] =
            b[0] * p[0][c] + b[1] * p[along][c] + b[2] * p[2 * along][c] + b[3] * p[3 * along][c];
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const auto w = bernstein(is_row ? u[i] : v[i]);
      Quantities q;
      for (std::size_t c = 0; c < edge_quantities; ++c) {
        q[c] = w[0] * line[0][c] + w[1] * line[1][c] + w[2] * line[2][c] + w[3] * line[3][c];
      }
      s[is_row ? 3 * k + i : 3 * i + k] = vertex(q);
    }
  }

  // Of a half of a piece: six of its nine are the whole's.
  Samples samples_of_half(const Samples& whole, const Rectangle& half, bool along_u,
                          bool is_high) const {
    const std::size_t stride = along_u ? 1 : 3, from = is_high ? stride : 0;
    Samples s;
    for (std::size_t line = 0; line < 3; ++line) {
      const std::size_t n = line * (4 - stride);
      s[n] = whole[n + from];
      s[n + 2 * stride] = whole[n + from + stride];
    }
    put_line(half, 1, !along_u, s);
    return s;
  }

  // Largest second differences along lines of a stride.
  struct Bend {
    double direction = 0;
    double rest = 0;  // of light and picture, over what is flat
  };

  Bend bend(const Samples& s, std::size_t stride, double flat_picture_px) const {
    Bend most;
    for (std::size_t line = 0; line < 3; ++line) {
      const std::size_t n = line * (4 - stride);
      const ConeVertex &a = s[n], &b = s[n + stride], &c = s[n + 2 * stride];
      const auto second = [&](double ConeVertex::*q) { return a.*q - 2 * b.*q + c.*q; };
      const double x = second(&ConeVertex::dx), y = second(&ConeVertex::dy),
                   z = second(&ConeVertex::dz);
      most.direction = std::max(most.direction, std::sqrt(x * x + y * y + z * z));
      const double column = second(&ConeVertex::x), row = second(&ConeVertex::y);
      most.rest = std::max(
          {most.rest, std::sqrt(column * column + row * row) / flat_picture_px,
           importance * std::abs(second(&ConeVertex::throughput)) / (flat_share * brightest)});
    }
    return most;
  }

  // Lights [first, end) of the stack reach the piece's parent.
  void piece(const Rectangle& r, const Samples& s, int depth, std::size_t first) {
    double light = 0;
    for (const ConeVertex& v : s) {
      if (v.facing >= 0 && v.margin >= 0) light = std::max(light, v.throughput);
    }
    if (light == 0 && depth > 2) return;
    if (depth == 0) {
      brightest = std::max(least_light, light);
      flat = integrator.flat_direction(importance);
    }
    const double flat_picture_px = flat_picture(s, light);
    const Bend u = bend(s, 1, flat_picture_px), v = bend(s, 3, flat_picture_px);
    // The middle of a curve stands out of its chord by half its second difference: twice that.
    const double slack = std::max(u.direction, v.direction);
    std::array<std::array<double, 3>, 9> directions;
    for (std::size_t n = 0; n < 9; ++n) directions[n] = {s[n].dx, s[n].dy, s[n].dz};
    const std::size_t end = lights.size();
    for (std::size_t k = first; k < end; ++k) {
      const Cone& cone = integrator.cones[static_cast<std::size_t>(lights[k])];
      if (!beyond_a_side(cone, directions, slack)) lights.push_back(lights[k]);
    }
    if (lights.size() > end) {
      // Toward the edge directions bend without bound while their light fades: what counts is both.
      const double weight = std::min(1.0, 2 * light / brightest) / flat;
      const double u_bend = std::max(weight * u.direction, u.rest);
      const double v_bend = std::max(weight * v.direction, v.rest);
      // Quads of half the size bend by a quarter of it; chord_factor as for the other patches.
      const bool is_flat = std::max(u_bend, v_bend) < 4 / chord_factor;
      if (is_flat || is_small(s, flat_picture_px) || depth >= deepest) {
        leaf(s, end);
      } else {
        halve_piece(r, s, u_bend >= v_bend, depth, end);
      }
    }
    lights.resize(end);
  }

  // Toward the outline a piece of the surface is a sliver of the picture, as wide as the square of
  // the cosine: where its light counts, a chord must keep within that.
  double flat_picture(const Samples& s, double light) const {
    if (light < 0.1 * brightest) return integrator.flat_picture_px;
    double most_facing = 0;
    for (const ConeVertex& v : s) most_facing = std::max(most_facing, v.facing);
    return integrator.flat_picture_px * std::clamp(most_facing * most_facing, 1e-4, 1.0);
  }

  // Both diagonals within what is flat in the picture: a finer cut would move no light to speak of.
  static bool is_small(const Samples& s, double flat_picture_px) {
    const auto apart = [](const ConeVertex& a, const ConeVertex& b) {
      return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
    };
    const double flat_2 = flat_picture_px * flat_picture_px;
    return apart(s[0], s[8]) < flat_2 && apart(s[2], s[6]) < flat_2;
  }

  void halve_piece(const Rectangle& r, const Samples& s, bool along_u, int depth,
                   std::size_t first) {
    const RectangleHalves halves = halves_of(r, along_u);
    piece(halves.low, samples_of_half(s, halves.low, along_u, false), depth + 1, first);
    piece(halves.high, samples_of_half(s, halves.high, along_u, true), depth + 1, first);
  }

  void leaf(const Samples& s, std::size_t first) {
    for (std::size_t k = first; k < lights.size(); ++k) {
      for (const std::size_t n : {0u, 1u, 3u, 4u}) {
        integrator.add_triangle(lights[k], slice, s[n], s[n + 1], s[n + 4]);
        integrator.add_triangle(lights[k], slice, s[n], s[n + 4], s[n + 3]);
      }
    }
  }
};

// Lights that the nodes' directions reach, or what lies between them: half their spread more.
std::vector<int> lights_near(const Integrator& integrator, const FieldPatch& patch) {
  std::vector<Eigen::Vector3d> directions = node_directions(integrator.field, patch);
  Eigen::Vector3d mean = {0, 0, 0};
  for (const Eigen::Vector3d& d : directions) mean += d / static_cast<double>(directions.size());
  for (Eigen::Vector3d& d : directions) d += 0.5 * (d - mean);
  return integrator.lights_in_reach(directions);
}

}  // namespace

void integrate_edge_patch(Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  std::vector<int> lights = lights_near(integrator, patch);
  if (lights.empty()) return;
  bool refracted = false;
  const CellPolynomial<edge_quantities> polynomial(field.times, [&](std::size_t place) {
    const std::uint32_t n = cell.nodes[place];
    const PathExit& e = *find_exit(field, n, patch.signature);
    const Node v = integrator.node_values(n, e);
    refracted = e.refracted;
    return std::array<double, edge_quantities>{
        e.incident.x(), e.incident.y(), e.incident.z(), e.normal.x(), e.normal.y(), e.normal.z(),
        e.power_s,      e.power_p,      v[column],      v[row],       v[facing]};
  });
  const Motion motion = node_motion(integrator, patch);
  for (const Slice& slice : integrator.slices(cell, motion, patch.importance)) {
    const EdgeNet net = polynomial.at(slice.cell_share);
    EdgeCutter cutter{.integrator = integrator,
                      .net = net,
                      .slice = slice,
                      .refracted = refracted,
                      .importance = patch.importance,
                      .lights = lights};
    if (integrator.is_delta) {
      integrator.add_glints(lights, slice, [&](double u, double v) { return cutter.point(u, v); });
    } else {
      cutter.piece({}, cutter.samples({}), 0, 0);
    }
  }
}

}  // namespace pluvia
