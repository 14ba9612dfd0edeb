#include "raytrace/light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace pluvia {
namespace {

constexpr double least_distance_m = 1e-3;

double cosine_deg(double angle_deg) {
  return std::cos(angle_deg * std::numbers::pi / 180);
}

}  // namespace

SpotCosines spot_cosines(const Light& light) {
  const double outer = cosine_deg(light.outer_half_angle_deg);
  return {std::max(cosine_deg(light.inner_half_angle_deg), outer + 1e-6), outer};
}

Illumination illumination(const Light& light, const Eigen::Vector3d& at_m) {
  if (light.kind == LightKind::sun)
    return {-light.direction, std::numeric_limits<double>::infinity(), light.illuminance_lux};
  Illumination lit;
  const Eigen::Vector3d to_light = light.position_m - at_m;
  lit.distance_m = to_light.norm();
  if (lit.distance_m > 0) lit.toward = to_light / lit.distance_m;
  const double near_m = std::max({lit.distance_m, light.radius_m, least_distance_m});
  lit.lux = light.intensity_cd / (near_m * near_m);
  if (light.kind == LightKind::spot) {
    const SpotCosines rim = spot_cosines(light);
    const double cosine = -lit.toward.dot(light.direction);
    const double t = std::clamp((cosine - rim.outer) / (rim.inner - rim.outer), 0.0, 1.0);
    lit.lux *= t * t;
  }
  return lit;
}

bool inside_lamp(const Light& light, const Illumination& lit, double drop_radius_m) {
  return !(lit.distance_m > light.radius_m + drop_radius_m);
}

}  // namespace pluvia
