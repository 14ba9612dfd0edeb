#include "oscillation/fall_speed.h"

#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr double water_density_kg_m3 = 998.2;
constexpr double surface_tension_n_m = 0.0728;

template <std::size_t n>
double polynomial(const std::array<double, n>& c, double x) {
  double value = 0;
  for (std::size_t k = n; k-- > 0;) value = value * x + c[k];
  return value;
}

// Sutherland's law, constants of the 1976 standard atmosphere.
double air_viscosity_pa_s(double temperature_k) {
  return 1.458e-6 * std::pow(temperature_k, 1.5) / (temperature_k + 110.4);
}

// Reynolds number of the drop between 19 um and 1.07 mm, from its Davies number.
double reynolds_of_small_drop(double davies) {
  return std::exp(polynomial<7>(
      {-3.18657, 0.992696, -1.53193e-3, -9.87059e-4, -5.78878e-4, 8.55176e-5, -3.27815e-6},
      std::log(davies)));
}

// .. and above 1.07 mm, from its Bond number and the physical property number.
double reynolds_of_large_drop(double bond, double property) {
  const double root = std::pow(property, 1.0 / 6);
  return root *
         std::exp(polynomial<6>({-5.00015, 5.23778, -2.04914, 0.475294, -0.0542819, 0.00238449},
                                std::log(bond * root)));
}

void refuse_unknown_air(const Air& air) {
  if (!(air.temperature_c >= -40 && air.temperature_c <= 50)) {
    throw std::invalid_argument(
        fmt::format("temperature_c = {}; expected -40 <= temperature_c <= 50", air.temperature_c));
  }
  if (!(air.pressure_pa >= 1e4 && air.pressure_pa <= 1.2e5)) {
    throw std::invalid_argument(
        fmt::format("pressure_pa = {}; expected 1e4 <= pressure_pa <= 1.2e5", air.pressure_pa));
  }
}

}  // namespace

double fall_speed_m_s(double diameter_m, const Air& air) {
  if (!(diameter_m > 0 && diameter_m <= 7e-3)) {
    throw std::invalid_argument(
        fmt::format("diameter_m = {}; expected 0 < diameter_m <= 0.007", diameter_m));
  }
  refuse_unknown_air(air);
  const double temperature_k = air.temperature_c + 273.15;
  const double air_density = air.pressure_pa / (287.05 * temperature_k);
  const double viscosity = air_viscosity_pa_s(temperature_k);
  const double excess = water_density_kg_m3 - air_density;
  // Mean free path scaled from 6.62e-8 m at 20 C and 101325 Pa (viscosity 1.818e-5 Pa s).
  const double free_path_m = 6.62e-8 * (viscosity / 1.818e-5) * (101325 / air.pressure_pa) *
                             std::sqrt(temperature_k / 293.15);
  const double slip = 1 + 2.51 * free_path_m / diameter_m;
  if (diameter_m < 19e-6) {
    return excess * gravity_m_s2 * diameter_m * diameter_m * slip / (18 * viscosity);
  }
  double reynolds = 0;
  if (diameter_m < 1.07e-3) {
    const double davies = 4 * air_density * excess * gravity_m_s2 * std::pow(diameter_m, 3) /
                          (3 * viscosity * viscosity);
    reynolds = slip * reynolds_of_small_drop(davies);
  } else {
    const double bond =
        4 * excess * gravity_m_s2 * diameter_m * diameter_m / (3 * surface_tension_n_m);
    const double property = std::pow(surface_tension_n_m, 3) * air_density * air_density /
                            (std::pow(viscosity, 4) * excess * gravity_m_s2);
    reynolds = reynolds_of_large_drop(bond, property);
  }
  return viscosity * reynolds / (air_density * diameter_m);
}

double garg_nayar_fall_speed_m_s(double radius_m) {
  return 200 * std::sqrt(radius_m);
}

}  // namespace pluvia
