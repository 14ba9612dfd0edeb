#include "raytrace/preset.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "oscillation/water.h"
#include "raytrace/spherical_harmonics.h"
#include "raytrace/toml_reader.h"

namespace pluvia {

namespace {

constexpr double least_cone_deg = 0.05;

constexpr int most_rows = 1 << 20;  // what a manifest takes (atlas/manifest.cpp)

void refuse_thin_drop(const TomlReader& table, const Preset& preset, const OscillationSet& set) {
  for (const int diameter_um : diameters_of(preset)) {
    const auto nearest = too_near_surface(drop_of(preset, set, diameter_um), span_of(preset));
    if (!nearest) continue;
    table.refuse(preset.physical ? "mode" : "A20",
                 fmt::format("set {}: the drop's surface comes as near as {:.3f} r0 to its centre; "
                             "expected more than {} r0 (smaller {})",
                             set.index, *nearest, smallest_relative_radius,
                             preset.physical ? "amplitudes" : "A20, A31"));
  }
}

OscillationSet read_set(TomlReader& table, const Preset& preset) {
  const OscillationSet set = preset.physical ? read_physical_set(table) : read_gn2006_set(table);
  for (const OscillationSet& other : preset.sets) {
    if (other.index == set.index) {
      table.refuse("index", fmt::format("index = {} again; expected each index once", set.index));
    }
  }
  refuse_thin_drop(table, preset, set);
  return set;
}

// Needs the preset's drops and exposure, which decide how thin the drops of the sets become.
void read_sets(const std::string& file, Preset& preset) {
  const toml::table document = read_toml(file);
  TomlReader top(document, file, "");
  if (preset.physical && top.has("amplitude_factor")) {
    preset.physical->amplitude = read_amplitude_factor(top.table("amplitude_factor"));
  }
  for (TomlReader& table : top.tables("set")) preset.sets.push_back(read_set(table, preset));
  top.finish();
  if (preset.sets.empty()) {
    throw std::runtime_error(file + ":1:1: no [[set]]; expected at least one oscillation set");
  }
  refuse_wrong_mirrors(file, preset.sets);
}

void read_accuracy(TomlReader accuracy, Preset& preset) {
  if (preset.physical) {
    accuracy.required("slices_per_row", preset.physical->slices_per_row, {0, 100, true});
    accuracy.required("slices_per_period", preset.physical->slices_per_period, {0, 10000, true});
  } else {
    accuracy.required("slices", preset.slices, 1, 1000000);
  }
  accuracy.required("spans_per_period", preset.spans_per_period, {0, 1000, true});
  accuracy.required("base_cells", preset.field.base_cells, 2, 256);
  accuracy.required("space_depth", preset.field.space_depth, 0, 8);
  accuracy.required("time_depth", preset.field.time_depth, 0, 8);
  accuracy.required("bend_tolerance", preset.field.bend_tolerance, {0, 10, true});
  accuracy.required("motion_tolerance", preset.motion_tolerance, {0, 10});
  accuracy.finish();
}

void read_drop(TomlReader drop, Preset& preset) {
  if (preset.physical) {
    read_physical_drop(drop, *preset.physical);
    preset.density_kg_m3 = water_density_kg_m3(preset.physical->air.temperature_c);
    preset.surface_tension_n_m = water_surface_tension_n_m(preset.physical->air.temperature_c);
    return;
  }
  drop.required("mean_radius_m", preset.mean_radius_m, {1e-5, 1e-2}, "m");
  drop.required("density_kg_m3", preset.density_kg_m3, {1, 1e5}, "kg/m^3");
  drop.required("surface_tension_n_m", preset.surface_tension_n_m, {0, 10, true}, "N/m");
  drop.required("refractive_index", preset.field.paths.refractive_index, {1, 4});
  drop.finish();
}

void read_exposure(TomlReader& exposure, Preset& preset) {
  exposure.required("exposure_s", preset.exposure_s, {0, 1, true}, "s");
  if (preset.physical) {
    preset.physical->span_s = preset.exposure_s;
    exposure.optional("span_s", preset.physical->span_s, {preset.exposure_s, 10}, "s");
  } else {
    exposure.required("fall_speed_m_s", preset.fall_speed_m_s, {0, 20, true}, "m/s");
  }
  exposure.finish();
}

void read_light(TomlReader light, Preset& preset) {
  light.required("cone_half_angle_deg", preset.cone_half_angle_deg, {0, 30}, "deg");
  if (preset.cone_half_angle_deg > 0 && preset.cone_half_angle_deg < least_cone_deg) {
    light.refuse("cone_half_angle_deg",
                 fmt::format("cone_half_angle_deg = {} deg; expected 0 (points at infinity) or {} "
                             ".. 30",
                             preset.cone_half_angle_deg, least_cone_deg));
  }
  light.required("max_order", preset.field.paths.max_order, 0, 20);
  int grid_step_deg = 20;
  light.optional("grid_step_deg", grid_step_deg, 5, 20);
  if (20 % grid_step_deg != 0 || grid_step_deg % 5 != 0) {
    light.refuse("grid_step_deg",
                 fmt::format("grid_step_deg = {}; expected 20, 10 or 5", grid_step_deg));
  }
  preset.lights = light_grid(grid_step_deg);
  if (preset.physical) {
    read_bands(light, *preset.physical);
    preset.field.paths.refractive_index = preset.physical->bands.front().refractive_index;
  }
  light.finish();
}

void read_picture(TomlReader picture, Preset& preset) {
  picture.required("width_px", preset.width_px, 4, 64);
  if ((preset.width_px & (preset.width_px - 1)) != 0) {
    picture.refuse("width_px",
                   fmt::format("width_px = {}; expected a power of two", preset.width_px));
  }
  picture.optional("view_elevations_deg", preset.view_elevations_deg, preset.physical ? -80 : 0,
                   80);
  picture.optional("oscillations", preset.oscillations, 0, 99);
  if (preset.physical) {
    preset.environment = false;
    picture.optional("environment", preset.environment);
  }
  picture.optional("transfer_degree", preset.transfer_degree, 0, highest_harmonic_degree);
  picture.finish();
  for (const char* key : {"view_elevations_deg", "oscillations"}) {
    std::vector<int> list = key[0] == 'v' ? preset.view_elevations_deg : preset.oscillations;
    if (list.empty()) picture.refuse(key, fmt::format("{} is empty; expected some", key));
    std::sort(list.begin(), list.end());
    const auto twice = std::adjacent_find(list.begin(), list.end());
    if (twice != list.end())
      picture.refuse(key, fmt::format("{}: {} again; expected each once", key, *twice));
  }
  for (const int index : preset.oscillations) {
    if (std::none_of(preset.sets.begin(), preset.sets.end(),
                     [&](const OscillationSet& set) { return set.index == index; })) {
      picture.refuse("oscillations",
                     fmt::format("oscillation {}; expected one of the oscillation file's", index));
    }
  }
}

nlohmann::json json_of_sets(const Preset& preset) {
  nlohmann::json sets = nlohmann::json::array();
  for (const OscillationSet& set : preset.sets) {
    nlohmann::json json = {{"index", set.index}, {"phi_drop_deg", set.phi_drop_deg}};
    if (preset.physical) {
      json["modes"] = nlohmann::json::array();
      for (const Mode& mode : set.modes) {
        json["modes"].push_back({{"n", mode.n},
                                 {"m", mode.m},
                                 {"amplitude", mode.amplitude},
                                 {"phase_rad", mode.phase_rad}});
      }
    } else {
      json["A20"] = set.a20;
      json["A31"] = set.a31;
    }
    sets.push_back(json);
  }
  return sets;
}

// Of the whole fall at view 0, whose pictures are the highest.
void refuse_high_pictures(const TomlReader& exposure, const Preset& preset) {
  for (const int diameter_um : diameters_of(preset)) {
    const SizeRecord size = size_of(preset, diameter_um);
    const double rows = preset.width_px + size.fall_speed_m_s * size.span_s / size.pixel_m;
    if (rows < most_rows) continue;
    exposure.refuse("span_s", fmt::format("drops of {} mm fall {:.0f} rows in span_s = {} s; "
                                          "expected less than {}",
                                          diameter_um / 1000.0, rows, size.span_s, most_rows));
  }
}

// The heights are those of the published pictures: a longer fall would be cut off at their last
// row.
void refuse_long_fall(const TomlReader& exposure, const Preset& preset) {
  if (preset.physical) return refuse_high_pictures(exposure, preset);
  const StreakFrame frame = gn2006_frame(preset, 0);
  const double end_row = frame.path_top_row + frame.path_rows;
  if (end_row <= frame.height_px) return;
  exposure.refuse("exposure_s",
                  fmt::format("the drop falls to row {:.1f} of the picture; expected at most {} "
                              "(exposure_s fall_speed_m_s <= {:.4g} m)",
                              end_row, frame.height_px,
                              (frame.height_px - frame.path_top_row) * frame.pixel_m));
}

}  // namespace

Preset read_preset(const std::string& file) {
  const toml::table document = read_toml(file);
  TomlReader top(document, file, "");
  Preset preset;
  std::string oscillation_file;
  top.required("preset", preset.name);
  if (preset.name != "gn2006" && preset.name != "physical") {
    top.refuse("preset",
               fmt::format("preset = \"{}\"; expected \"gn2006\" or \"physical\"", preset.name));
  }
  if (preset.name == "physical") preset.physical.emplace();
  top.required("oscillation_file", oscillation_file);
  top.optional("seed", preset.seed);
  read_drop(top.table("drop"), preset);
  TomlReader exposure = top.table("exposure");
  read_exposure(exposure, preset);
  read_sets(path_beside(file, oscillation_file), preset);
  read_light(top.table("light"), preset);
  read_picture(top.table("picture"), preset);
  refuse_long_fall(exposure, preset);
  read_accuracy(top.table("accuracy"), preset);
  top.finish();
  return preset;
}

std::string preset_parameters(const Preset& preset) {
  nlohmann::json parameters = {{"oscillation_sets", json_of_sets(preset)},
                               {"tracer_version", tracer_version},
                               {"density_kg_m3", preset.density_kg_m3},
                               {"surface_tension_n_m", preset.surface_tension_n_m},
                               {"max_order", preset.field.paths.max_order},
                               {"min_power", preset.field.paths.min_power},
                               {"exposure_s", preset.exposure_s},
                               {"cone_half_angle_deg", preset.cone_half_angle_deg},
                               {"width_px", preset.width_px},
                               {"base_cells", preset.field.base_cells},
                               {"spans_per_period", preset.spans_per_period},
                               {"space_depth", preset.field.space_depth},
                               {"time_depth", preset.field.time_depth},
                               {"bend_tolerance", preset.field.bend_tolerance},
                               {"motion_tolerance", preset.motion_tolerance}};
  if (preset.physical) {
    parameters.update(nlohmann::json::parse(physical_parameters(*preset.physical)));
  } else {
    parameters["mean_radius_m"] = preset.mean_radius_m;
    parameters["refractive_index"] = preset.field.paths.refractive_index;
    parameters["fall_speed_m_s"] = preset.fall_speed_m_s;
    parameters["slices"] = preset.slices;
  }
  if (preset.target_error > 0) {
    // The settings follow from it.
    for (const char* key :
         {"base_cells", "spans_per_period", "space_depth", "time_depth", "bend_tolerance",
          "motion_tolerance", "slices", "slices_per_row", "slices_per_period"}) {
      parameters.erase(key);
    }
    parameters["target_error"] = preset.target_error;
  }
  // All absent where nothing is left out or added.
  if (!preset.environment) parameters["environment"] = false;
  if (preset.transfer_degree >= 0) parameters["transfer_degree"] = preset.transfer_degree;
  if (preset.lights != gn2006_light_directions()) {
    parameters["lights"] = nlohmann::json::array();
    for (const LightDirection& light : preset.lights) {
      parameters["lights"].push_back(light_name(light));
    }
  }
  return parameters.dump();
}

}  // namespace pluvia
