#include "raytrace/light_integral.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "raytrace/bezier_patch.h"
#include "raytrace/glints.h"

namespace pluvia {

namespace {

// A piece of a patch is cut into two triangles when it bends by less than this share of the cone,
// this much of a pixel and this share of its light.
constexpr double flat_share = 0.02;
constexpr double flat_px = 0.05;
constexpr double flat_radii = 0.004;  // .. or of the drop's radius, where pixels are coarser
constexpr double glint_px = 1e-3;  // what the glint of a delta light covers of the picture
constexpr int deepest_piece = 14;  // halvings, of either axis: a piece of 2^-7 of a cell

// Patches with less light than reflection at normal incidence are cut less finely, in proportion,
// down to a tenth of it.
constexpr double faint_light = 0.02;
constexpr double least_light = 0.002;

// What a patch holds at its nodes, or control points.
enum : std::size_t { dir_x, dir_y, dir_z, column, row, light, facing, quantities };
using Node = std::array<double, quantities>;
using Patch = BezierNet<quantities>;
using DirectionNet = BezierNet<3>;

struct Rectangle {
  double u0 = 0, u1 = 1, v0 = 0, v1 = 1;
};

// A bound on the distance between a curve and its chord, from its control points: n (n - 1) / 8
// times their largest second difference, n = 3.
constexpr double chord_factor = 0.75;

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

// True when all directions are beyond one side of the cone: so is everything between them.
template <typename Directions>
bool beyond_a_side(const Cone& cone, const Directions& directions) {
  return std::any_of(cone.inward.begin(), cone.inward.end(), [&](const Eigen::Vector3d& n) {
    return std::all_of(std::begin(directions), std::end(directions), [&](const auto& d) {
      return n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0;
    });
  });
}

struct Integrator {
  const ExitField& field;
  const StreakFrame& frame;
  std::span<const Moment> moments, surface_moments;
  StreakWindow& window;
  std::vector<Cone> cones = {};
  double weight = 0;  // of a light's polygon: 1 / (pi sin^2 half_angle)
  double flat_picture_px = flat_px;
  bool is_delta = false;  // the lights are points at infinity

  Node node_values(std::uint32_t index, const PathExit& exit) const {
    const FieldNode& n = field.nodes[index];
    return {exit.direction.x(),
            exit.direction.y(),
            exit.direction.z(),
            frame.centre_column + n.xy_m.x() / frame.pixel_m,
            -n.xy_m.y() / frame.pixel_m,
            exit.throughput,
            n.facing};
  }

  // What counts as flat for directions: a share of the cone, more where the light is faint.
  double flat_direction(double brightest) const {
    return flat_share * std::tan(cones.front().half_angle_rad) *
           std::max(1.0, faint_light / brightest);
  }

  std::span<const Moment> within(std::span<const Moment> all, const FieldCell& cell) const {
    const auto from = std::lower_bound(
        all.begin(), all.end(), cell.first,
        [](const Moment& m, double share) { return m.span_share < share; });
    const bool to_the_end = cell.last == 1;
    const auto to = to_the_end ? all.end()
                               : std::lower_bound(from, all.end(), cell.last,
                                                  [](const Moment& m, double share) {
                                                    return m.span_share < share;
                                                  });
    return {from, to};
  }

  void add_triangle(int light, const Moment& moment, const ConeVertex& a, const ConeVertex& b,
                    const ConeVertex& c) {
    const Cone& cone = cones[static_cast<std::size_t>(light)];
    if (is_delta) {
      if (const auto glint = glint_in_triangle(cone.axis, a, b, c)) {
        add_glint(light, moment, *glint);
      }
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
    deposit(window, light, moment.travel, polygon, moment.time_share * weight);
  }

  void add_glints(const std::vector<int>& lights, const Moment& moment, const PatchMap& map) {
    std::vector<Eigen::Vector3d> directions;
    for (const int light : lights) {
      directions.push_back(cones[static_cast<std::size_t>(light)].axis);
    }
    find_glints(map, directions, [&](std::size_t k, const Glint& glint) {
      add_glint(lights[k], moment, glint);
    });
  }

  // As a square: its sides share it out between pixels that meet in it.
  void add_glint(int light, const Moment& moment, const Glint& glint) {
    ConePolygon square;
    square.count = 4;
    for (std::size_t k = 0; k < 4; ++k) {
      const double x = k == 1 || k == 2 ? 0.5 : -0.5, y = k >= 2 ? 0.5 : -0.5;
      square.vertices[k] = {0, 0, 0, glint.x + x * glint_px, glint.y + y * glint_px, 1, 1, 1};
    }
    deposit(window, light, moment.travel, square,
            moment.time_share * glint.light / (glint_px * glint_px));
  }
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
};

double share_of_cell(const FieldCell& cell, const Moment& moment) {
  return (moment.span_share - cell.first) / (cell.last - cell.first);
}

// Picture, throughput and facing of a patch at (u, v).
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

// A smooth patch: its polynomial at any moment, cut up where a light's cone is.
struct SmoothPatch {
  Integrator& integrator;
  const FieldCell& cell;
  CellPolynomial<quantities> polynomial;

  SmoothPatch(Integrator& integral, const FieldPatch& patch)
      : integrator(integral),
        cell(integral.field.cells[patch.cell]),
        polynomial(integral.field.times, [&](std::size_t place) {
          const std::uint32_t node = cell.nodes[place];
          return integral.node_values(node, *find_exit(integral.field, node, patch.signature));
        }) {}

  // Lights whose cone the patch can reach at some time, by the hull of all control points.
  std::vector<int> lights_in_reach() const {
    std::vector<std::array<double, 3>> directions;
    for (int k = 0; k < polynomial.times; ++k) {
      for (const Node& p : polynomial.nets[static_cast<std::size_t>(k)]) {
        directions.push_back({p[dir_x], p[dir_y], p[dir_z]});
      }
    }
    std::vector<int> found;
    for (std::size_t l = 0; l < integrator.cones.size(); ++l) {
      if (!beyond_a_side(integrator.cones[l], directions)) found.push_back(static_cast<int>(l));
    }
    return found;
  }

  void integrate() const;
};

// A patch at one moment, cut up as finely as the lights in its reach need.
struct PatchCutter {
  Integrator& integrator;
  const Patch& patch;
  const Moment& moment;
  std::vector<int>& lights;       // a stack: the last entries are those of the piece at hand
  double flat = 0;                // what counts as flat for a direction
  double bend_u = 0, bend_v = 0;  // of picture and throughput over the whole patch, over what is flat

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
    const auto length = [](const std::array<double, 3>& d) {
      return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    };
    const double du = r.u1 - r.u0, dv = r.v1 - r.v0;
    const double u_bend =
        std::max(chord_factor * second_difference(net, 1, length) / flat, bend_u * du * du);
    const double v_bend =
        std::max(chord_factor * second_difference(net, 4, length) / flat, bend_v * dv * dv);
    std::array<double, 3> twist;
    for (std::size_t c = 0; c < 3; ++c) twist[c] = net[0][c] - net[3][c] - net[12][c] + net[15][c];
    const double skew = 0.25 * length(twist) / flat;
    if (depth >= deepest_piece || std::max({u_bend, v_bend, skew}) < 1) {
      leaf(net, r, first);
      return;
    }
    const bool along_u = u_bend > v_bend || (u_bend == v_bend && du >= dv);
    DirectionNet low, high;
    halve(net, along_u ? 1 : 4, low, high);
    Rectangle a = r, b = r;
    if (along_u) {
      a.u1 = b.u0 = 0.5 * (r.u0 + r.u1);
    } else {
      a.v1 = b.v0 = 0.5 * (r.v0 + r.v1);
    }
    piece(low, a, depth + 1, first);
    piece(high, b, depth + 1, first);
  }

  void leaf(const DirectionNet& net, const Rectangle& r, std::size_t first) {
    const std::array<ConeVertex, 4> corners = {
        patch_corner(patch, net[0], r.u0, r.v0), patch_corner(patch, net[3], r.u1, r.v0),
        patch_corner(patch, net[15], r.u1, r.v1), patch_corner(patch, net[12], r.u0, r.v1)};
    for (std::size_t k = first; k < lights.size(); ++k) {
      integrator.add_triangle(lights[k], moment, corners[0], corners[1], corners[2]);
      integrator.add_triangle(lights[k], moment, corners[0], corners[2], corners[3]);
    }
  }
};

void SmoothPatch::integrate() const {
  std::vector<int> lights = lights_in_reach();
  if (lights.empty()) return;
  for (const Moment& moment : integrator.within(integrator.moments, cell)) {
    const Patch net = polynomial.at(share_of_cell(cell, moment));
    if (std::all_of(net.begin(), net.end(), [](const Node& p) { return p[facing] < 0; })) continue;
    if (integrator.is_delta) {
      integrator.add_glints(lights, moment,
                            [&](double u, double v) { return patch_point(net, u, v); });
      continue;
    }
    PatchCutter cutter{.integrator = integrator, .patch = net, .moment = moment, .lights = lights};
    double brightest = least_light;
    for (const Node& p : net) brightest = std::max(brightest, p[light]);
    cutter.flat = integrator.flat_direction(brightest);
    const auto size = [&](const Node& d) {
      return std::max(std::hypot(d[column], d[row]) / integrator.flat_picture_px,
                      std::abs(d[light]) / (flat_share * brightest));
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

// What an edge patch holds at its nodes: the beam that meets the last interface, and the picture.
enum : std::size_t {
  incident_x, incident_y, incident_z, normal_x, normal_y, normal_z, part_s, part_p,
  edge_column, edge_row, edge_facing, edge_quantities
};
using EdgeNet = BezierNet<edge_quantities>;

// A patch whose map has an edge where the last interface turns to total reflection: what meets that
// interface is the polynomial, what leaves it is computed at each point. Pieces are sampled at 3 x 3
// points, and halved where a light may reach them until they are flat.
struct EdgeCutter {
  Integrator& integrator;
  const EdgeNet& net;
  const Moment& moment;
  bool refracted = true;
  std::vector<int>& lights;  // a stack: the last entries are those of the piece at hand
  double flat = 0;
  double brightest = least_light;  // of the whole patch

  using Samples = std::array<ConeVertex, 9>;  // u fastest
  static constexpr int deepest = 12;          // halvings, of either axis

  using Quantities = std::array<double, edge_quantities>;

  ConeVertex vertex(const Quantities& q) const {
    const InterfaceExit exit = leave_interface(
        refracted, {q[incident_x], q[incident_y], q[incident_z]},
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

  Samples samples(const Rectangle& r) const {
    Samples s;
    const std::array<std::array<double, 4>, 3> bu = {
        bernstein(r.u0), bernstein(0.5 * (r.u0 + r.u1)), bernstein(r.u1)};
    for (std::size_t j = 0; j < 3; ++j) {
      const auto bv = bernstein(r.v0 + 0.5 * static_cast<double>(j) * (r.v1 - r.v0));
      std::array<Quantities, 4> line;  // of the net at this v
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t c = 0; c < edge_quantities; ++c) {
          line[i][c] = bv[0] * net[i][c] + bv[1] * net[4 + i][c] + bv[2] * net[8 + i][c] +
                       bv[3] * net[12 + i][c];
        }
      }
      for (std::size_t i = 0; i < 3; ++i) {
        Quantities q;
        for (std::size_t c = 0; c < edge_quantities; ++c) {
          q[c] = bu[i][0] * line[0][c] + bu[i][1] * line[1][c] + bu[i][2] * line[2][c] +
                 bu[i][3] * line[3][c];
        }
        s[3 * j + i] = vertex(q);
      }
    }
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
      const auto second = [&](double ConeVertex::* q) { return a.*q - 2 * b.*q + c.*q; };
      const double x = second(&ConeVertex::dx), y = second(&ConeVertex::dy),
                   z = second(&ConeVertex::dz);
      most.direction = std::max(most.direction, std::sqrt(x * x + y * y + z * z));
      const double column = second(&ConeVertex::x), row = second(&ConeVertex::y);
      most.rest = std::max({most.rest, std::sqrt(column * column + row * row) / flat_picture_px,
                            std::abs(second(&ConeVertex::throughput)) / (flat_share * brightest)});
    }
    return most;
  }

  // Lights [first, end) of the stack reach the piece's parent.
  void piece(const Rectangle& r, int depth, std::size_t first) {
    const Samples s = samples(r);
    double light = 0;
    for (const ConeVertex& v : s) {
      if (v.facing >= 0 && v.margin >= 0) light = std::max(light, v.throughput);
    }
    if (light == 0 && depth > 2) return;
    if (depth == 0) {
      brightest = std::max(least_light, light);
      flat = integrator.flat_direction(brightest);
    }
    const double flat_picture_px = flat_picture(s, light);
    const Bend u = bend(s, 1, flat_picture_px), v = bend(s, 3, flat_picture_px);
    const std::size_t end = lights.size();
    for (std::size_t k = first; k < end; ++k) {
      const Cone& cone = integrator.cones[static_cast<std::size_t>(lights[k])];
      // The middle of a curve stands out of its chord by half its second difference: twice that.
      if (!misses(cone, s, std::max(u.direction, v.direction))) lights.push_back(lights[k]);
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
        halve_piece(r, u_bend >= v_bend, depth, end);
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
      return std::hypot(a.x - b.x, a.y - b.y);
    };
    return apart(s[0], s[8]) < flat_picture_px && apart(s[2], s[6]) < flat_picture_px;
  }

  static bool misses(const Cone& cone, const Samples& s, double slack) {
    return std::any_of(cone.inward.begin(), cone.inward.end(), [&](const Eigen::Vector3d& n) {
      return std::all_of(s.begin(), s.end(), [&](const ConeVertex& v) {
        return n.x() * v.dx + n.y() * v.dy + n.z() * v.dz < -slack;
      });
    });
  }

  void halve_piece(const Rectangle& r, bool along_u, int depth, std::size_t first) {
    Rectangle a = r, b = r;
    if (along_u) {
      a.u1 = b.u0 = 0.5 * (r.u0 + r.u1);
    } else {
      a.v1 = b.v0 = 0.5 * (r.v0 + r.v1);
    }
    piece(a, depth + 1, first);
    piece(b, depth + 1, first);
  }

  void leaf(const Samples& s, std::size_t first) {
    for (std::size_t k = first; k < lights.size(); ++k) {
      for (const std::size_t n : {0u, 1u, 3u, 4u}) {
        integrator.add_triangle(lights[k], moment, s[n], s[n + 1], s[n + 4]);
        integrator.add_triangle(lights[k], moment, s[n], s[n + 4], s[n + 3]);
      }
    }
  }
};

// Lights whose cone reaches a patch's nodes, and what lies between: half their spread more.
std::vector<int> lights_near_nodes(const Integrator& integrator, const FieldPatch& patch);

void integrate_edge_patch(Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  std::vector<int> lights = lights_near_nodes(integrator, patch);
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
  for (const Moment& moment : integrator.within(integrator.moments, cell)) {
    const EdgeNet net = polynomial.at(share_of_cell(cell, moment));
    EdgeCutter cutter{.integrator = integrator,
                      .net = net,
                      .moment = moment,
                      .refracted = refracted,
                      .lights = lights};
    if (integrator.is_delta) {
      integrator.add_glints(lights, moment,
                            [&](double u, double v) { return cutter.point(u, v); });
    } else {
      cutter.piece({}, 0, 0);
    }
  }
}

// Where in a cell's time a moment is: between the nodes `before` and the next.
struct BetweenNodes {
  std::size_t before = 0;
  double share = 0;
};

BetweenNodes between_nodes(const ExitField& field, const FieldCell& cell, double span_share) {
  if (field.times == 1) return {};
  const double at = (cell_side - 1) * (span_share - cell.first) / (cell.last - cell.first);
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, cell_side - 2.0));
  return {before, at - static_cast<double>(before)};
}

// Corner of the quad at (i, j) of a cell, k = 0 .. 3 around it: its place among a plane's 16 nodes.
std::size_t corner_place(std::size_t i, std::size_t j, std::size_t k) {
  return cell_side * (j + (k / 2)) + i + ((k == 1 || k == 2) ? 1 : 0);
}

ConeVertex to_vertex(const Node& n) {
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
  for (std::size_t c = 0; c < quantities; ++c) (*before)[c] += t.share * ((*after)[c] - (*before)[c]);
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

std::vector<int> lights_near_nodes(const Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  std::vector<Eigen::Vector3d> directions;
  Eigen::Vector3d mean = {0, 0, 0};
  for (int n = 0; n < 16 * field.times; ++n) {
    const std::uint32_t node = field.cells[patch.cell].nodes[static_cast<std::size_t>(n)];
    const PathExit* exit = find_exit(field, node, patch.signature);
    if (!exit) continue;
    directions.push_back(exit->direction);
    mean += exit->direction;
  }
  mean /= static_cast<double>(directions.size());
  if (patch.kind == PatchKind::edge) {
    for (Eigen::Vector3d& d : directions) d += 0.5 * (d - mean);
  }
  std::vector<int> found;
  for (std::size_t l = 0; l < integrator.cones.size(); ++l) {
    if (!beyond_a_side(integrator.cones[l], directions)) found.push_back(static_cast<int>(l));
  }
  return found;
}

void integrate_loose_patch(Integrator& integrator, const FieldPatch& patch) {
  const ExitField& field = integrator.field;
  const FieldCell& cell = field.cells[patch.cell];
  const std::vector<int> lights = lights_near_nodes(integrator, patch);
  if (lights.empty()) return;
  const auto node_at = [&](std::size_t time, std::size_t place) -> std::optional<Node> {
    const std::uint32_t node = cell.nodes[16 * time + place];
    const PathExit* exit = find_exit(field, node, patch.signature);
    if (!exit) return std::nullopt;
    return integrator.node_values(node, *exit);
  };
  for (const Moment& moment : integrator.within(integrator.moments, cell)) {
    const BetweenNodes t = between_nodes(field, cell, moment.span_share);
    for_loose_triangles(
        t, field.times, node_at,
        [&](const ConeVertex& a, const ConeVertex& b, const ConeVertex& c) {
          for (const int light : lights) integrator.add_triangle(light, moment, a, b, c);
        });
  }
}

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

  void add(const Moment& moment, const ValueRows& rows, const ConeVertex& a, const ConeVertex& b,
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
      deposit(integrator.window, surface.uniform_plane(), moment.travel, polygon,
              moment.time_share);
    }
    if (rows.size() > 0) surface.many.add(moment.travel, polygon, moment.time_share, others);
    for (int k = 0; k < polygon.count; ++k) {
      polygon.vertices[static_cast<std::size_t>(k)].throughput = 1;
    }
    deposit(integrator.window, surface.coverage_plane(), moment.travel, polygon, moment.time_share);
  }

  // Twice as fine as the nodes where the outline passes: a chord's bulge shrinks to a quarter.
  void add_whole(const CellPolynomial<quantities>& polynomial, bool at_outline,
                 const Moment& moment) const {
    const double share = share_of_cell(cell, moment);
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
        add(moment, rows, grid[j][i], grid[j][i + 1], grid[j + 1][i + 1]);
        add(moment, rows, grid[j][i], grid[j + 1][i + 1], grid[j + 1][i]);
      }
    }
  }

  void add_loose(const Moment& moment) const {
    const ExitField& field = integrator.field;
    const auto node_at = [&](std::size_t time, std::size_t place) -> std::optional<Node> {
      if (!field.nodes[cell.nodes[16 * time + place]].known) return std::nullopt;
      return values(16 * time + place);
    };
    const BetweenNodes t = between_nodes(field, cell, moment.span_share);
    ValueRows rows;
    if (surface.many.count > 0) rows = other.loose(field, cell, t.before, t.share);
    for_loose_triangles(t, field.times, node_at,
                        [&](const ConeVertex& a, const ConeVertex& b, const ConeVertex& c) {
                          add(moment, rows, a, b, c);
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
    const auto moments = integrator.within(integrator.surface_moments, cell);
    if (!whole) {
      for (const Moment& moment : moments) add_loose(moment);
      return;
    }
    const CellPolynomial<quantities> polynomial(integrator.field.times,
                                                [&](std::size_t place) { return values(place); });
    for (const Moment& moment : moments) add_whole(polynomial, behind, moment);
  }
};

}  // namespace

void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      std::span<const Moment> moments, std::span<const Moment> surface_moments,
                      StreakWindow& window, const EnvironmentRequest& environment) {
  Integrator integrator{.field = field,
                        .frame = frame,
                        .moments = moments,
                        .surface_moments = surface_moments,
                        .window = window};
  for (const Eigen::Vector3d& axis : lights.directions) {
    integrator.cones.push_back(make_cone(axis, lights.half_angle_rad));
  }
  integrator.flat_picture_px = std::min(flat_px, flat_radii * field.radius_m / frame.pixel_m);
  integrator.is_delta = lights.half_angle_rad == 0;
  if (!integrator.is_delta) {
    const double sine = std::sin(lights.half_angle_rad);
    integrator.weight = 1 / (std::numbers::pi * sine * sine);
  }
  for (const FieldPatch& patch : field.patches) {
    switch (patch.kind) {
      case PatchKind::smooth:
        SmoothPatch(integrator, patch).integrate();
        break;
      case PatchKind::edge:
        integrate_edge_patch(integrator, patch);
        break;
      case PatchKind::loose:
        integrate_loose_patch(integrator, patch);
        break;
    }
  }
  Surface surface{.integrator = integrator,
                  .environment = environment,
                  .many = make_value_deposit(window, value_count(environment)),
                  .none = std::vector<double>(value_count(environment))};
  for (const std::uint32_t cell : field.surfaces) {
    SurfaceCell(surface, field.cells[cell]).integrate();
  }
  surface.many.add_to(window, surface.coverage_plane() + 1);
}

}  // namespace pluvia
