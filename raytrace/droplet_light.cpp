#include "raytrace/droplet_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double index = 1.333;
constexpr int orders = 12;          // what is left after them is less than 1e-4
constexpr int incidences = 200000;  // rings of equal area

// Of the power that meets the sphere, what leaves with an order.
double left_with(int order, double reflectance) {
  if (order == 0) return reflectance;
  return (1 - reflectance) * (1 - reflectance) * std::pow(reflectance, order - 1);
}

}  // namespace

std::vector<double> droplet_phase(int bins) {
  std::vector<double> phase(static_cast<std::size_t>(bins), 0.0);
  double all = 0;
  for (int i = 0; i < incidences; ++i) {
    const double sin_i = std::sqrt((i + 0.5) / incidences);
    const double incidence = std::asin(sin_i), refraction = std::asin(sin_i / index);
    // Fresnel. Not raytrace/optics.h: the renderer never sees the tracer, which judges it.
    const double s =
        std::pow(std::sin(incidence - refraction) / std::sin(incidence + refraction), 2);
    const double p =
        std::pow(std::tan(incidence - refraction) / std::tan(incidence + refraction), 2);
    for (int order = 0; order < orders; ++order) {
      const double turned = order == 0 ? pi - 2 * incidence
                                       : 2 * incidence - 2 * order * refraction + (order - 1) * pi;
      const double angle = std::acos(std::clamp(std::cos(turned), -1.0, 1.0));
      const auto bin = std::min(static_cast<int>(angle / pi * bins), bins - 1);
      const double power = 0.5 * (left_with(order, s) + left_with(order, p));
      phase[static_cast<std::size_t>(bin)] += power;
      all += power;
    }
  }
  for (int bin = 0; bin < bins; ++bin) {
    const double solid_sr = 2 * pi * (std::cos(bin * pi / bins) - std::cos((bin + 1) * pi / bins));
    phase[static_cast<std::size_t>(bin)] /= all * solid_sr;
  }
  return phase;
}

}  // namespace pluvia
