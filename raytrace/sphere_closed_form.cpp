#include "raytrace/sphere_closed_form.h"

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

double ray_intensity(double refractive_index, int order, double incidence) {
  const double b = std::sin(incidence), cr = std::sqrt(1 - std::pow(b / refractive_index, 2));
  // d deviation / d i; b db = sin i cos i di.
  const double slope =
      order == 0 ? 2 : 2 - 2 * order * std::cos(incidence) / (refractive_index * cr);
  return sphere_throughput(refractive_index, order, b) * b * std::cos(incidence) / std::abs(slope);
}

// Calls visit(intensity, position) for each ray of an order that leaves at that scattering angle;
// position: its impact, > 0 on the side of the disc from which the light comes. What enters the
// drop turns toward the axis (order >= 1): it is seen on the other side, unless it has turned by
// more than half a circle.
template <typename Visit>
void for_each_ray(double refractive_index, int order, double angle_rad, Visit visit) {
  constexpr int steps = 2000;  // no deviation turns twice within pi / 4000
  for (int k = 0; k < steps; ++k) {
    const double i = pi / 2 * k / steps, j = pi / 2 * (k + 1) / steps;
    const double from = sphere_deviation_rad(refractive_index, order, i);
    const double to = sphere_deviation_rad(refractive_index, order, j);
    // The angle's images: +-angle plus whole turns.
    for (int turn = -order - 1; turn <= order + 1; ++turn) {
      for (const double sign : {1.0, -1.0}) {
        const double image = 2 * pi * turn + sign * angle_rad;
        if ((from < image) == (to < image)) continue;
        const double incidence = sphere_incidence_rad(refractive_index, order, image, i, j);
        visit(ray_intensity(refractive_index, order, incidence),
              (order == 0 ? sign : -sign) * std::sin(incidence));
      }
    }
  }
}

}  // namespace

double sphere_deviation_rad(double refractive_index, int order, double incidence_rad) {
  if (order == 0) return pi - 2 * incidence_rad;
  const double r = std::asin(std::sin(incidence_rad) / refractive_index);
  return 2 * incidence_rad - 2 * order * r + (order - 1) * pi;
}

double sphere_incidence_rad(double refractive_index, int order, double deviation_rad, double low,
                            double high) {
  const auto deviation = [&](double incidence_rad) {
    return sphere_deviation_rad(refractive_index, order, incidence_rad);
  };
  const bool rises = deviation(high) > deviation(low);
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const bool above = deviation(middle) > deviation_rad;
    (above == rises ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

double sphere_order_intensity(double refractive_index, int order, double angle_rad) {
  double sum = 0;
  for_each_ray(refractive_index, order, angle_rad,
               [&](double intensity, double) { sum += intensity; });
  return sum / (pi * std::sin(angle_rad));
}

double sphere_intensity(double refractive_index, int max_order, double angle_rad) {
  double sum = 0;
  for (int order = 0; order <= max_order; ++order)
    sum += sphere_order_intensity(refractive_index, order, angle_rad);
  return sum;
}

double sphere_light_position(double refractive_index, int max_order, double angle_rad) {
  double sum = 0, moment = 0;
  for (int order = 0; order <= max_order; ++order) {
    for_each_ray(refractive_index, order, angle_rad, [&](double intensity, double position) {
      sum += intensity;
      moment += intensity * position;
    });
  }
  return moment / sum;
}

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
  const double deviation = sphere_deviation_rad(refractive_index, order, std::asin(impact));
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
