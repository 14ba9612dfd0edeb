#include "data/scenes/street_shapes.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace street {
namespace {

std::uint16_t vertex(Part& part, const Vector3d& p) {
  const auto millimetres = [](double m) { return static_cast<int>(std::lround(1000 * m)); };
  const std::array<int, 3> key = {millimetres(p.x()), millimetres(p.z()), -millimetres(p.y())};
  const auto next = static_cast<std::uint16_t>(part.positions_m.size() / 3);
  const auto [found, added] = part.known.try_emplace(key, next);
  if (added)
    for (int value : key) part.positions_m.push_back(static_cast<float>(value) / 1000);
  return found->second;
}

// Counter-clockwise from outside.
void quad(Part& part, std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
  part.indices.insert(part.indices.end(), {a, b, c, a, c, d});
}

}  // namespace

void rectangle(Street& street, Surface surface, const std::array<Vector3d, 4>& corner) {
  Part& part = street.parts[surface];
  std::array<std::uint16_t, 4> v{};
  for (std::size_t i = 0; i < 4; ++i) v[i] = vertex(part, corner[i]);
  quad(part, v[0], v[1], v[2], v[3]);
}

void loft(Street& street, Surface surface, const std::vector<Vector3d>& low,
          const std::vector<Vector3d>& high) {
  Part& part = street.parts[surface];
  std::vector<std::uint16_t> a, b;
  for (const Vector3d& p : low) a.push_back(vertex(part, p));
  for (const Vector3d& p : high) b.push_back(vertex(part, p));
  for (std::size_t i = 0; i < low.size(); ++i) {
    const std::size_t j = (i + 1) % low.size();
    quad(part, a[i], a[j], b[j], b[i]);
  }
  for (std::size_t i = 2; i < high.size(); ++i)
    part.indices.insert(part.indices.end(), {b[0], b[i - 1], b[i]});
}

std::vector<Vector3d> outline(const Frame& f, double u0, double u1, double w0, double w1,
                              double z) {
  return {f.at(u0, w1, z), f.at(u1, w1, z), f.at(u1, w0, z), f.at(u0, w0, z)};
}

void block(Street& street, Surface surface, const Frame& f, double u0, double u1, double w0,
           double w1, double z0, double z1) {
  loft(street, surface, outline(f, u0, u1, w0, w1, z0), outline(f, u0, u1, w0, w1, z1));
}

void ledge(Street& street, Surface surface, const Frame& f, double u0, double u1, double w0,
           double w1, double z0, double z1) {
  block(street, surface, f, u0, u1, w0, w1, z0, z1);
  rectangle(street, surface,
            {f.at(u0, w0, z0), f.at(u1, w0, z0), f.at(u1, w1, z0), f.at(u0, w1, z0)});
}

void cylinder(Street& street, Surface surface, const Vector3d& base, const Vector3d& axis,
              double base_radius_m, double top_radius_m, int sides) {
  const Vector3d side = axis.unitOrthogonal(), other = axis.normalized().cross(side);
  std::vector<Vector3d> low, high;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    const Vector3d ray = std::cos(angle) * side + std::sin(angle) * other;
    low.push_back(base + base_radius_m * ray);
    high.push_back(base + axis + top_radius_m * ray);
  }
  loft(street, surface, low, high);
}

void wall_cell(Street& street, Surface surface, const Frame& f, double u0, double u1, double z0,
               double z1, const Opening& o) {
  Part& part = street.parts[surface];
  const auto ring = [&](double a, double b, double c, double d, double w) {
    return std::array<std::uint16_t, 4>{vertex(part, f.at(a, w, c)), vertex(part, f.at(b, w, c)),
                                        vertex(part, f.at(b, w, d)), vertex(part, f.at(a, w, d))};
  };
  const auto outer = ring(u0, u1, z0, z1, 0), inner = ring(o.u0, o.u1, o.z0, o.z1, 0),
             back = ring(o.u0, o.u1, o.z0, o.z1, -o.depth);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    quad(part, outer[i], outer[j], inner[j], inner[i]);
    quad(part, inner[i], inner[j], back[j], back[i]);
  }
  rectangle(street, o.pane,
            {f.at(o.u0, -o.depth, o.z0), f.at(o.u1, -o.depth, o.z0), f.at(o.u1, -o.depth, o.z1),
             f.at(o.u0, -o.depth, o.z1)});
}

}  // namespace street
