#include "oscillation/water.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr double ice_point_k = 273.15;

struct Limits {
  double low = 0, high = 0;
};

// Also refuses nan.
void refuse_outside(const char* name, double value, const Limits& limits) {
  if (value >= limits.low && value <= limits.high) return;
  throw std::invalid_argument(fmt::format("{0} = {1}; expected {2} <= {0} <= {3}", name, value,
                                          limits.low, limits.high));
}

}  // namespace

double water_density_kg_m3(double temperature_c) {
  refuse_outside("temperature_c", temperature_c, {0, 150});
  const double t = temperature_c;
  const double expanded =
      999.83952 +
      t * (16.945176 +
           t * (-7.9870401e-3 + t * (-46.170461e-6 + t * (105.56302e-9 - t * 280.54253e-12))));
  return expanded / (1 + 16.879850e-3 * t);
}

double water_surface_tension_n_m(double temperature_c) {
  refuse_outside("temperature_c", temperature_c, {-25, 370});
  const double tau = 1 - (temperature_c + ice_point_k) / 647.096;
  return 235.8e-3 * std::pow(tau, 1.256) * (1 - 0.625 * tau);
}

double water_index(double density_kg_m3, double temperature_c, double wavelength_nm) {
  refuse_outside("density_kg_m3", density_kg_m3, {0, 1060});
  refuse_outside("temperature_c", temperature_c, {-12, 500});
  refuse_outside("wavelength_nm", wavelength_nm, {200, 1100});
  const double rho = density_kg_m3 / 1000;
  const double t = (temperature_c + ice_point_k) / ice_point_k;
  const double lambda2 = std::pow(wavelength_nm / 589, 2);
  const double ultraviolet2 = std::pow(0.2292020, 2), infrared2 = std::pow(5.432937, 2);
  const double sum = 0.244257733 + 9.74634476e-3 * rho - 3.73234996e-3 * t +
                     2.68678472e-4 * lambda2 * t + 1.58920570e-3 / lambda2 +
                     2.45934259e-3 / (lambda2 - ultraviolet2) +
                     0.900704920 / (lambda2 - infrared2) - 1.66626219e-2 * rho * rho;
  const double a = rho * sum;
  return std::sqrt((2 * a + 1) / (1 - a));
}

double air_index(double temperature_c, double pressure_pa, double wavelength_nm) {
  refuse_outside("temperature_c", temperature_c, {-40, 100});
  refuse_outside("pressure_pa", pressure_pa, {1e4, 1.2e5});
  refuse_outside("wavelength_nm", wavelength_nm, {300, 1690});
  const double per_um2 = std::pow(1000 / wavelength_nm, 2);
  const double standard = 1e-8 * (5792105 / (238.0185 - per_um2) + 167917 / (57.362 - per_um2));
  const double density = pressure_pa / 101325 * (15 + ice_point_k) / (temperature_c + ice_point_k);
  return 1 + standard * density;
}

double drop_index(double temperature_c, double pressure_pa, double wavelength_nm) {
  refuse_outside("temperature_c", temperature_c, {0, 100});
  return water_index(water_density_kg_m3(temperature_c), temperature_c, wavelength_nm) /
         air_index(temperature_c, pressure_pa, wavelength_nm);
}

}  // namespace pluvia
