#include "validate/sphere_closed_form.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr int quadrature_points =
    100000;  // midpoints in b^2: errors below 1e-5 for cones above 0.2 deg

// Share of the circle of scattering angle `angle` that lies within `cone` of a point at `centre`.
double ring_share(double angle, double centre, double cone) {
  if (std::abs(angle - centre) >= cone) {
    return angle + centre < cone || 2 * pi - angle - centre < cone ? 1 : 0;
  }
  const double across = std::sin(angle) * std::sin(centre);
  if (across < 1e-300) return 1;
  const double c = (std::cos(cone) - std::cos(angle) * std::cos(centre)) / across;
  return std::acos(std::clamp(c, -1.0, 1.0)) / pi;
}

}  // namespace

double sphere_throughput(double refractive_index, int order, double impact) {
  const double ci = std::sqrt(std::max(0.0, 1 - impact * impact));
  const double sr = impact / refractive_index;
  const double cr = std::sqrt(1 - sr * sr);
  const double rs = std::pow((ci - refractive_index * cr) / (ci + refractive_index * cr), 2);
  const double rp = std::pow((refractive_index * ci - cr) / (refractive_index * ci + cr), 2);
  const auto share = [order](double r) {
    return order == 0 ? r : (1 - r) * (1 - r) * std::pow(r, order - 1);
  };
  return 0.5 * (share(rs) + share(rp));
}

double sphere_scattering_angle_rad(double refractive_index, int order, double impact) {
  const double i = std::asin(impact), r = std::asin(impact / refractive_index);
  const double deviation = order == 0 ? pi - 2 * i : 2 * i - 2 * order * r + (order - 1) * pi;
  return std::abs(std::remainder(deviation, 2 * pi));
}

double sphere_energy(double refractive_index, int order) {
  double sum = 0;
  for (int k = 0; k < quadrature_points; ++k) {
    // b = sin of a uniform angle: throughput is smooth in it up to the rim, where b^2 is not.
    const double i = pi / 2 * (k + 0.5) / quadrature_points;
    sum += sphere_throughput(refractive_index, order, std::sin(i)) * std::sin(2 * i);
  }
  return sum * pi / 2 / quadrature_points;
}

double sphere_rainbow_rad(double refractive_index, int order) {
  const double n2 = refractive_index * refractive_index;
  const double ci = std::sqrt((n2 - 1) / (order * order - 1.0));
  return sphere_scattering_angle_rad(refractive_index, order, std::sqrt(1 - ci * ci));
}

double sphere_intensity_in_cone(double refractive_index, int max_order, double centre_rad,
                                double cone_half_angle_rad) {
  double sum = 0;
  for (int order = 0; order <= max_order; ++order) {
    for (int k = 0; k < quadrature_points; ++k) {
      const double b = std::sqrt((k + 0.5) / quadrature_points);
      const double angle = sphere_scattering_angle_rad(refractive_index, order, b);
      const double share = ring_share(angle, centre_rad, cone_half_angle_rad);
      if (share > 0) sum += share * sphere_throughput(refractive_index, order, b);
    }
  }
  const double sine = std::sin(cone_half_angle_rad);
  return sum / quadrature_points / (pi * sine * sine);
}

}  // namespace pluvia
