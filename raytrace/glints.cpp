#include "raytrace/glints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace pluvia {

namespace {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector3d;

constexpr int deepest = 24;  // halvings, of either axis: a piece of 2^-12 of the square

// Newton's method starts in the middle of a piece whose map is one to one: where no part of it is
// more than this often as large, in solid angle, as another.
constexpr double even_map = 2;

constexpr double derivative_step = 1e-4;  // of the square: central differences err by its square

// A root is told apart from a piece's edges (multiples of 2^-12) up to Newton's own rounding: the
// same root found from two neighbours is rounded to the same number, in one of them.
constexpr double root_grid = 0x1p-36;

struct Frame {
  Vector3d axis, e1, e2;

  explicit Frame(const Vector3d& light)
      : axis(light), e1(light.unitOrthogonal()), e2(light.cross(e1)) {}

  static double dot(const Vector3d& n, const ConeVertex& p) {
    return n.x() * p.dx + n.y() * p.dy + n.z() * p.dz;
  }
  double along(const ConeVertex& p) const { return dot(axis, p); }
  Vector2d across(const ConeVertex& p) const { return {dot(e1, p), dot(e2, p)}; }
  // In the plane at distance 1 on the axis, whose area at the axis is solid angle.
  Vector2d on_plane(const ConeVertex& p) const { return across(p) / along(p); }
};

bool is_lit(const ConeVertex& p) {
  return p.facing > 0 && p.margin > 0 && p.throughput > 0;
}

struct Derivatives {
  Matrix2d plane, picture;  // with respect to (u, v)
};

Derivatives derivatives(const PatchMap& map, const Frame& frame, const Vector2d& at) {
  Derivatives d;
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = derivative_step * Vector2d::Unit(k);
    const ConeVertex after = map(at.x() + step.x(), at.y() + step.y());
    const ConeVertex before = map(at.x() - step.x(), at.y() - step.y());
    d.plane.col(k) = (frame.on_plane(after) - frame.on_plane(before)) / (2 * derivative_step);
    d.picture.col(k) = Vector2d(after.x - before.x, after.y - before.y) / (2 * derivative_step);
  }
  return d;
}

// Where the map has the light's direction near `at`; nothing where Newton's method does not settle
// within a square of the given half side.
std::optional<Vector2d> polished(const PatchMap& map, const Frame& frame, const Vector2d& at,
                                 double reach) {
  Vector2d now = at;
  for (int k = 0; k < 20; ++k) {
    const ConeVertex p = map(now.x(), now.y());
    if (frame.along(p) <= 0) return std::nullopt;
    const Matrix2d plane = derivatives(map, frame, now).plane;
    const Vector2d step = plane.inverse() * frame.on_plane(p);
    now -= step;
    if (!((now - at).lpNorm<Eigen::Infinity>() <= reach)) return std::nullopt;  // also not a number
    if (step.norm() < 1e-13) return now;
  }
  return std::nullopt;
}

std::optional<Glint> glint_at(const PatchMap& map, const Frame& frame, const Vector2d& at) {
  const ConeVertex p = map(at.x(), at.y());
  if (!is_lit(p)) return std::nullopt;
  const Derivatives d = derivatives(map, frame, at);
  const double light = p.throughput * std::abs(d.picture.determinant() / d.plane.determinant());
  if (!(light > 0) || !std::isfinite(light)) return std::nullopt;  // the fold itself
  return Glint{p.x, p.y, light};
}

struct Finder {
  const PatchMap& map;
  const std::vector<Frame>& frames;
  const std::function<void(std::size_t, const Glint&)>& take;
  std::vector<std::size_t> lights = {};  // a stack: the last entries are those of the piece at hand

  using Samples = std::array<ConeVertex, 9>;  // u fastest

  struct Piece {
    double u = 0, v = 0, width = 1, height = 1;
  };

  Samples samples(const Piece& r) const {
    Samples s;
    for (std::size_t n = 0; n < 9; ++n) {
      s[n] = map(r.u + 0.5 * r.width * static_cast<double>(n % 3),
                 r.v + 0.5 * r.height * static_cast<double>(n / 3));
    }
    return s;
  }

  static Vector3d direction(const ConeVertex& p) { return {p.dx, p.dy, p.dz}; }

  // Largest second difference of directions along lines of a stride.
  static double bend(const Samples& s, std::size_t stride) {
    double most = 0;
    for (std::size_t line = 0; line < 3; ++line) {
      const std::size_t n = line * (4 - stride);
      most = std::max(
          most,
          (direction(s[n]) - 2 * direction(s[n + stride]) + direction(s[n + 2 * stride])).norm());
    }
    return most;
  }

  // The middle of a curve stands out of its chord by half its second difference: twice that.
  static bool misses(const Frame& frame, const Samples& s, double slack) {
    const auto all = [&](const auto& test) { return std::all_of(s.begin(), s.end(), test); };
    for (const Vector3d& e : {frame.e1, frame.e2}) {
      if (all([&](const ConeVertex& p) { return Frame::dot(e, p) > slack; })) return true;
      if (all([&](const ConeVertex& p) { return Frame::dot(e, p) < -slack; })) return true;
    }
    return all([&](const ConeVertex& p) { return frame.along(p) < -slack; });
  }

  static bool is_one_to_one(const Samples& s) {
    const Vector3d middle = direction(s[4]);
    double least = 1e300, most = -1e300;
    for (const std::size_t n : {0u, 1u, 3u, 4u}) {
      const Vector3d a = direction(s[n]), b = direction(s[n + 1]), c = direction(s[n + 4]),
                     d = direction(s[n + 3]);
      for (const double area :
           {(b - a).cross(c - a).dot(middle), (c - a).cross(d - a).dot(middle)}) {
        least = std::min(least, area);
        most = std::max(most, area);
      }
    }
    return (least > 0 && most < even_map * least) || (most < 0 && least > even_map * most);
  }

  // Lights [first, end) of the stack reach the piece's parent.
  void piece(const Piece& r, int depth, std::size_t first) {
    const Samples s = samples(r);
    if (depth > 2 && std::none_of(s.begin(), s.end(), is_lit)) return;
    const double u_bend = bend(s, 1), v_bend = bend(s, 3);
    const std::size_t end = lights.size();
    for (std::size_t k = first; k < end; ++k) {
      if (!misses(frames[lights[k]], s, std::max(u_bend, v_bend))) lights.push_back(lights[k]);
    }
    if (lights.size() > end) {
      if (is_one_to_one(s) || depth >= deepest) {
        for (std::size_t k = end; k < lights.size(); ++k) look_for(lights[k], r);
      } else {
        halve_piece(r, u_bend > v_bend || (u_bend == v_bend && r.width >= r.height), depth, end);
      }
    }
    lights.resize(end);
  }

  void halve_piece(const Piece& r, bool along_u, int depth, std::size_t first) {
    Piece a = r;
    (along_u ? a.width : a.height) *= 0.5;
    Piece b = a;
    (along_u ? b.u : b.v) += along_u ? a.width : a.height;
    piece(a, depth + 1, first);
    piece(b, depth + 1, first);
  }

  void look_for(std::size_t light, const Piece& r) const {
    const Vector2d middle = {r.u + 0.5 * r.width, r.v + 0.5 * r.height};
    const auto root = polished(map, frames[light], middle, 2 * std::max(r.width, r.height));
    if (!root) return;
    const double u = std::round(root->x() / root_grid) * root_grid;
    const double v = std::round(root->y() / root_grid) * root_grid;
    if (u < r.u || u >= r.u + r.width || v < r.v || v >= r.v + r.height) return;
    if (const auto glint = glint_at(map, frames[light], *root)) take(light, *glint);
  }
};

}  // namespace

void find_glints(const PatchMap& map, std::span<const Vector3d> lights,
                 const std::function<void(std::size_t, const Glint&)>& take) {
  const std::vector<Frame> frames(lights.begin(), lights.end());
  Finder finder{.map = map, .frames = frames, .take = take};
  for (std::size_t k = 0; k < frames.size(); ++k) finder.lights.push_back(k);
  finder.piece({}, 0, 0);
}

std::optional<Glint> glint_in_triangle(const Vector3d& light, const ConeVertex& a,
                                       const ConeVertex& b, const ConeVertex& c) {
  const Frame frame(light);
  const Vector2d pa = frame.across(a), pb = frame.across(b), pc = frame.across(c);
  const auto edge = [](const Vector2d& p, const Vector2d& q) {
    return p.x() * q.y() - p.y() * q.x();
  };
  // Of an edge through the light itself, which is its left side: the two triangles that share the
  // edge name its ends in opposite order.
  const auto left = [&](const Vector2d& p, const Vector2d& q) {
    const double e = edge(p, q);
    return e > 0 || (e == 0 && std::pair(p.x(), p.y()) < std::pair(q.x(), q.y()));
  };
  if (left(pa, pb) != left(pb, pc) || left(pb, pc) != left(pc, pa)) return std::nullopt;
  // Shares of the corners, and the doubled solid angle over the squared length.
  const double wa = edge(pb, pc), wb = edge(pc, pa), wc = edge(pa, pb), sum = wa + wb + wc;
  const auto mixed = [&](double ConeVertex::*q) {
    return (wa * a.*q + wb * b.*q + wc * c.*q) / sum;
  };
  const ConeVertex p = {mixed(&ConeVertex::dx),     mixed(&ConeVertex::dy),
                        mixed(&ConeVertex::dz),     mixed(&ConeVertex::x),
                        mixed(&ConeVertex::y),      mixed(&ConeVertex::throughput),
                        mixed(&ConeVertex::facing), mixed(&ConeVertex::margin)};
  const double along = frame.along(p);
  const double area = std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
  const double glint = p.throughput * area * along * along / std::abs(sum);
  if (!(along > 0) || !is_lit(p) || !(glint > 0) || !std::isfinite(glint)) return std::nullopt;
  return Glint{p.x, p.y, glint};
}

}  // namespace pluvia
