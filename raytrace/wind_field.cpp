#include "raytrace/wind_field.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "raytrace/key_path.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// G / (2 pi rho^2); its limit on the axis is 1 / (2 pi c^2).
double per_rho(double rho2, double core2) {
  const double x = rho2 / core2;
  if (x < 1e-12) return (1 - x / 2) / (2 * pi * core2);
  return -std::expm1(-x) / (2 * pi * rho2);
}

struct Rise {
  double flux = 0, change = 0;  // S in m, S'
};

Rise rise_of(double z_m, double height_m) {
  const double q = z_m / height_m;
  if (!(q > 0 && q < 1)) return {};
  const double scale = 686 * std::sqrt(7.0) / 27, p = q * (1 - q);
  return {scale * height_m * p * p * p * p, 4 * scale * p * p * p * (1 - 2 * q)};
}

Eigen::Vector3d tornado(const WindPrimitive& primitive, const Eigen::Vector3d& across, double z_m) {
  const double core2 = primitive.core_radius_m * primitive.core_radius_m;
  const double rho2 = across.squaredNorm();
  const Rise rise = rise_of(z_m, primitive.height_m);
  const double upward = rise.flux * std::exp(-rho2 / core2) / (pi * core2);
  return primitive.strength * per_rho(rho2, core2) * primitive.axis.cross(across) +
         primitive.inflow * std::abs(primitive.strength) *
             (upward * primitive.axis - rise.change * per_rho(rho2, core2) * across);
}

}  // namespace

WindPrimitive primitive_at(const WindPrimitive& primitive, double time_s) {
  WindPrimitive now = primitive;
  now.path.clear();
  if (primitive.path.empty()) return now;
  const auto& path = primitive.path;
  now.position_m = along_path(path, time_s, &WindKey::position_m);
  const std::size_t i = key_before(path, time_s);
  now.axis = path[i].axis;
  now.strength = path[i].strength;
  if (time_s < path.front().time_s || i + 1 == path.size()) return now;
  const double u = (time_s - path[i].time_s) / (path[i + 1].time_s - path[i].time_s);
  now.strength = (1 - u) * path[i].strength + u * path[i + 1].strength;
  now.axis = ((1 - u) * path[i].axis + u * path[i + 1].axis).normalized();
  return now;
}

Eigen::Vector3d wind_of(const WindPrimitive& primitive, const Eigen::Vector3d& at_m) {
  if (primitive.kind == WindKind::uniform) return primitive.strength * primitive.axis;
  const Eigen::Vector3d from = at_m - primitive.position_m;
  const double z_m = from.dot(primitive.axis);
  const Eigen::Vector3d across = from - z_m * primitive.axis;
  const double core2 = primitive.core_radius_m * primitive.core_radius_m;
  if (primitive.kind == WindKind::tornado) return tornado(primitive, across, z_m);
  const double share = primitive.strength * per_rho(across.squaredNorm(), core2);
  if (primitive.kind == WindKind::source) return share * across;
  return share * primitive.axis.cross(across);
}

Wind wind_at(const Wind& wind, double time_s) {
  Wind now = {.even_m_s = wind.even_m_s};
  for (const WindPrimitive& primitive : wind.primitives)
    now.primitives.push_back(primitive_at(primitive, time_s));
  return now;
}

Eigen::Vector3d velocity_m_s(const Wind& steady, const Eigen::Vector3d& at_m) {
  Eigen::Vector3d sum = steady.even_m_s;
  for (const WindPrimitive& primitive : steady.primitives) sum += wind_of(primitive, at_m);
  return sum;
}

double most_speed_m_s(const WindPrimitive& primitive) {
  const double strength = std::abs(primitive.strength), c = primitive.core_radius_m;
  if (primitive.kind == WindKind::uniform) return strength;
  constexpr double steepest = 0.63817268 / (2 * pi);  // of G / (2 pi rho) times c, at 1.1209 c
  if (primitive.kind != WindKind::tornado) return steepest * strength / c;
  const double inflow = std::abs(primitive.inflow) * strength;
  const double upward =
      inflow * rise_of(primitive.height_m / 2, primitive.height_m).flux / (pi * c * c);
  return std::hypot(steepest * std::hypot(strength, inflow) / c, upward);
}

}  // namespace pluvia
