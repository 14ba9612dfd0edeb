#include "raytrace/physical_rain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "oscillation/water.h"

namespace pluvia {

namespace {

bool is_band_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  return !name.empty() && name.size() <= 20 && letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

Band read_band(TomlReader table, const std::vector<Band>& others) {
  Band band;
  table.required("name", band.name);
  table.required("wavelength_nm", band.wavelength_nm, {300, 1100}, "nm");
  table.finish();
  if (!is_band_name(band.name)) {
    table.refuse("name", fmt::format("band \"{}\"; expected up to 20 letters, digits and _, a "
                                     "letter first",
                                     band.name));
  }
  if (std::any_of(others.begin(), others.end(),
                  [&](const Band& other) { return other.name == band.name; })) {
    table.refuse("name", fmt::format("band \"{}\" again; expected each name once", band.name));
  }
  return band;
}

int whole_um(TomlReader& drop, double diameter_mm) {
  const double um = 1000 * diameter_mm;
  // Half a nanometre is far beyond what a decimal number in mm loses to binary.
  if (std::abs(um - std::round(um)) > 1e-6) {
    drop.refuse("diameters_mm",
                fmt::format("diameter {} mm; expected whole micrometres", diameter_mm));
  }
  return static_cast<int>(std::lround(um));
}

// The sum over modes of |A P_nm| at that angle from the top, with the sign of the extreme, on top
// of the shape at rest: an extreme of r / r0 at any time and azimuth.
double extreme_radius(const DropShape& drop, double theta_rad, double sign) {
  double h = 1;
  for (std::size_t k = 0; k < drop.equilibrium_cos.size(); ++k) {
    h += drop.equilibrium_cos[k] * std::cos(static_cast<double>(k) * theta_rad);
  }
  for (const Mode& mode : drop.modes) {
    const double p = std::assoc_legendre(static_cast<unsigned>(mode.n),
                                         static_cast<unsigned>(mode.m), std::cos(theta_rad));
    h += sign * std::abs(mode.amplitude * p);
  }
  return h;
}

// Over theta: in steps of half a degree, which miss an extreme by (pi/720)^2 / 2 of the second
// derivative, 1e-4 for amplitudes that sum to 0.5 at degree 4.
double extreme_radius(const DropShape& drop, double sign) {
  double extreme = extreme_radius(drop, 0, sign);
  for (int i = 1; i <= 360; ++i) {
    const double value = extreme_radius(drop, i * std::numbers::pi / 360, sign);
    extreme = sign > 0 ? std::max(extreme, value) : std::min(extreme, value);
  }
  return extreme;
}

// Keeping the volume scales by (V/V0)^(-1/3), and V/V0 = mean of (1+h)^3 >= (1 + mean of h)^3
// (Jensen). Over the sphere cos k theta has the mean 1 / (1 - k^2) for even k, all else none.
double largest_scale(const DropShape& drop) {
  if (!drop.keep_volume) return 1;
  double mean = 1;
  for (std::size_t k = 0; k < drop.equilibrium_cos.size(); k += 2) {
    const auto degree = static_cast<double>(k);
    mean += drop.equilibrium_cos[k] / (1 - degree * degree);
  }
  return 1 / mean;
}

// How far the star centre moves from the centroid. Instants at golden-ratio steps of the slowest
// period meet all phases of all modes, since the frequencies are incommensurate.
double farthest_origin_m(const DropShape& drop) {
  int slowest = 10;
  for (const Mode& mode : drop.modes) slowest = std::min(slowest, mode.n);
  const double step_s =
      (std::numbers::phi - 1) * 2 * std::numbers::pi / mode_frequency_rad_s(drop, slowest);
  double farthest = 0;
  for (int i = 0; i < (is_rigid(drop) ? 1 : 64); ++i) {
    farthest = std::max(farthest, drop_at(drop, i * step_s).origin_m.norm());
  }
  return farthest;
}

}  // namespace

std::vector<Band> rgb_bands() {
  return {{.name = "B", .wavelength_nm = 437.41},
          {.name = "G", .wavelength_nm = 544.51},
          {.name = "R", .wavelength_nm = 634.09}};
}

void read_physical_drop(TomlReader drop, PhysicalRain& rain) {
  std::vector<double> diameters_mm;
  std::string equilibrium_file;
  drop.required("diameters_mm", diameters_mm, {0.01, 7}, "mm");
  drop.required("temperature_c", rain.air.temperature_c, {0, 50}, "C");
  drop.optional("pressure_pa", rain.air.pressure_pa, {1e4, 1.2e5}, "Pa");
  drop.optional("equilibrium_file", equilibrium_file);
  drop.optional("keep_volume", rain.keep_volume);
  drop.optional("keep_centroid", rain.keep_centroid);
  drop.finish();
  for (const double mm : diameters_mm) rain.diameters_um.push_back(whole_um(drop, mm));
  auto& um = rain.diameters_um;
  std::sort(um.begin(), um.end());
  const auto twice = std::adjacent_find(um.begin(), um.end());
  if (twice != um.end()) {
    drop.refuse("diameters_mm",
                fmt::format("diameter {} mm again; expected each once", *twice / 1000.0));
  }
  if (um.empty()) drop.refuse("diameters_mm", "diameters_mm is empty; expected some");
  if (!equilibrium_file.empty()) {
    rain.equilibrium = read_equilibrium_table(path_beside(drop.file(), equilibrium_file));
    const double largest_m = rain.equilibrium.diameter_m.back();
    if (um.back() * 1e-6 > largest_m)
      drop.refuse("diameters_mm",
                  fmt::format("diameter {} mm; expected at most {} mm, where {} ends",
                              um.back() / 1000.0, 1e3 * largest_m, equilibrium_file));
  }
}

void read_bands(TomlReader& light, PhysicalRain& rain) {
  Band single = {.wavelength_nm = 589};
  std::string names;
  light.optional("wavelength_nm", single.wavelength_nm, {300, 1100}, "nm");
  light.optional("bands", names);
  for (const TomlReader& band : light.tables("band")) {
    rain.bands.push_back(read_band(band, rain.bands));
  }
  if (light.has("bands") && names != "rgb") {
    light.refuse("bands",
                 fmt::format("bands = \"{}\"; expected \"rgb\", or [[light.band]]", names));
  }
  const char* given[] = {"wavelength_nm", "bands", "band"};
  if (std::count_if(std::begin(given), std::end(given),
                    [&](const char* key) { return light.has(key); }) > 1) {
    light.refuse(light.has("bands") ? "bands" : "wavelength_nm",
                 "light has two of wavelength_nm, bands, band; expected one of them");
  }
  if (light.has("bands")) rain.bands = rgb_bands();
  if (rain.bands.empty()) rain.bands = {single};
  std::sort(rain.bands.begin(), rain.bands.end(),
            [](const Band& a, const Band& b) { return a.name < b.name; });
  for (Band& band : rain.bands) {
    band.refractive_index =
        drop_index(rain.air.temperature_c, rain.air.pressure_pa, band.wavelength_nm);
  }
}

std::string physical_parameters(const PhysicalRain& rain) {
  nlohmann::json bands = nlohmann::json::array();
  for (const Band& band : rain.bands) {
    bands.push_back({{"name", band.name},
                     {"wavelength_nm", band.wavelength_nm},
                     {"refractive_index", band.refractive_index}});
  }
  const nlohmann::json parameters = {{"temperature_c", rain.air.temperature_c},
                                     {"pressure_pa", rain.air.pressure_pa},
                                     {"bands", bands},
                                     {"equilibrium_diameter_m", rain.equilibrium.diameter_m},
                                     {"equilibrium_cos_terms", rain.equilibrium.cos_terms},
                                     {"keep_volume", rain.keep_volume},
                                     {"keep_centroid", rain.keep_centroid},
                                     {"amplitude_factor_diameter_m", rain.amplitude.diameter_m},
                                     {"amplitude_factor", rain.amplitude.factor},
                                     {"span_s", rain.span_s},
                                     {"slices_per_row", rain.slices_per_row},
                                     {"slices_per_period", rain.slices_per_period}};
  return parameters.dump();
}

DropShape physical_drop(const PhysicalRain& rain, const OscillationSet& set, int diameter_um) {
  const double diameter_m = diameter_um * 1e-6;
  DropShape drop;
  drop.mean_radius_m = diameter_m / 2;
  drop.density_kg_m3 = water_density_kg_m3(rain.air.temperature_c);
  drop.surface_tension_n_m = water_surface_tension_n_m(rain.air.temperature_c);
  drop.phi_drop_rad = set.phi_drop_deg * std::numbers::pi / 180;
  drop.modes = shape_modes(set, amplitude_factor(rain.amplitude, diameter_m));
  if (!rain.equilibrium.diameter_m.empty()) {
    drop.equilibrium_cos = equilibrium_cos(rain.equilibrium, diameter_m);
  }
  const bool sphere = drop.modes.empty() && drop.equilibrium_cos.empty();
  drop.keep_volume = rain.keep_volume && !sphere;
  drop.keep_centroid = rain.keep_centroid && !sphere;
  return drop;
}

int slices_needed(const PhysicalRain& rain, const DropShape& drop, double path_rows) {
  double fastest_hz = 0;
  for (const Mode& mode : drop.modes) {
    fastest_hz = std::max(fastest_hz, mode_frequency_rad_s(drop, mode.n) / (2 * std::numbers::pi));
  }
  const double slices =
      std::max(rain.slices_per_row * path_rows, rain.slices_per_period * fastest_hz * rain.span_s);
  return std::max(1, static_cast<int>(std::ceil(slices)));
}

double drop_reach_m(const DropShape& drop) {
  // The centroid's sampled greatest shift can miss the true one; it is a few hundredths of r0, so a
  // fifth more is no loss.
  const double shift_m = drop.keep_centroid ? 1.2 * farthest_origin_m(drop) : 0;
  return drop.mean_radius_m * largest_scale(drop) * extreme_radius(drop, 1) + shift_m;
}

double least_relative_radius(const DropShape& drop) {
  // V/V0 is at most the cube of the largest radius, so the scale at least its inverse.
  const double scale = drop.keep_volume ? 1 / extreme_radius(drop, 1) : 1;
  return scale * extreme_radius(drop, -1);
}

}  // namespace pluvia
