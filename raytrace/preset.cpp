#include "raytrace/preset.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "oscillation/water.h"
#include "raytrace/spherical_harmonics.h"
#include "raytrace/toml_reader.h"

namespace pluvia {

namespace {

constexpr double drop_radius_px_of_16 = 5.6;
constexpr double path_top_px_of_16 = 9;

constexpr double least_cone_deg = 0.05;

constexpr int most_rows = 1 << 20;  // what a manifest takes (atlas/manifest.cpp)

DropShape drop_of(const Preset& preset, const OscillationSet& set, int diameter_um) {
  if (preset.physical) return physical_drop(*preset.physical, set, diameter_um);
  DropShape drop;
  drop.mean_radius_m = preset.mean_radius_m;
  drop.density_kg_m3 = preset.density_kg_m3;
  drop.surface_tension_n_m = preset.surface_tension_n_m;
  drop.phi_drop_rad = set.phi_drop_deg * std::numbers::pi / 180;
  drop.modes = shape_modes(set);
  return drop;
}

double span_of(const Preset& preset) {
  return preset.physical ? preset.physical->span_s : preset.exposure_s;
}

void refuse_thin_drop(const TomlReader& table, const Preset& preset, const OscillationSet& set) {
  for (const int diameter_um : diameters_of(preset)) {
    const DropShape drop = drop_of(preset, set, diameter_um);
    if (least_relative_radius(drop) > smallest_relative_radius) continue;
    const double nearest = minimum_relative_radius(drop, span_of(preset));
    if (nearest > smallest_relative_radius) continue;
    table.refuse(preset.physical ? "mode" : "A20",
                 fmt::format("set {}: the drop's surface comes as near as {:.3f} r0 to its centre; "
                             "expected more than {} r0 (smaller {})",
                             set.index, nearest, smallest_relative_radius,
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
    const auto& list = key[0] == 'v' ? preset.view_elevations_deg : preset.oscillations;
    if (list.empty()) picture.refuse(key, fmt::format("{} is empty; expected some", key));
  }
  for (const int index : preset.oscillations) {
    if (std::none_of(preset.sets.begin(), preset.sets.end(),
                     [&](const OscillationSet& set) { return set.index == index; })) {
      picture.refuse("oscillations",
                     fmt::format("oscillation {}; expected one of the oscillation file's", index));
    }
  }
}

double height_of_16(int view_elevation_deg) {
  switch (view_elevation_deg) {
    case 0:
      return 525;
    case 20:
      return 494;
    case 40:
      return 405;
    case 60:
      return 272;
    case 80:
      return 108;
    default:
      return 507 * std::cos(view_elevation_deg * std::numbers::pi / 180) + 18;
  }
}

double radians(int degrees) {
  return degrees * std::numbers::pi / 180;
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

double mean_refractive_index(const Preset& preset) {
  double sum = 0;
  const std::vector<Band> bands = bands_of(preset);
  for (const Band& band : bands) sum += band.refractive_index;
  return sum / static_cast<double>(bands.size());
}

const OscillationSet& set_of(const Preset& preset, int oscillation) {
  const auto set = std::find_if(preset.sets.begin(), preset.sets.end(),
                                [&](const OscillationSet& s) { return s.index == oscillation; });
  if (set == preset.sets.end()) {
    throw std::invalid_argument(fmt::format("oscillation {}; expected one of the sets of preset {}",
                                            oscillation, preset.name));
  }
  return *set;
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

StreakFrame gn2006_frame(const Preset& preset, int view_elevation_deg) {
  const double scale = preset.width_px / 16.0;
  StreakFrame frame;
  frame.width_px = preset.width_px;
  frame.height_px = static_cast<int>(std::ceil(height_of_16(view_elevation_deg) * scale - 1e-9));
  frame.pixel_m = preset.mean_radius_m / (drop_radius_px_of_16 * scale);
  frame.centre_column = preset.width_px / 2.0;
  frame.path_top_row = path_top_px_of_16 * scale;
  frame.path_rows = preset.fall_speed_m_s * preset.exposure_s *
                    std::cos(radians(view_elevation_deg)) / frame.pixel_m;
  return frame;
}

StreakFrame physical_frame(const Preset& preset, int diameter_um, int view_elevation_deg) {
  const SizeRecord size = size_of(preset, diameter_um);
  StreakFrame frame;
  frame.width_px = preset.width_px;
  frame.pixel_m = size.pixel_m;
  frame.centre_column = frame.path_top_row = preset.width_px / 2.0;
  frame.path_rows =
      size.fall_speed_m_s * size.span_s * std::cos(radians(view_elevation_deg)) / size.pixel_m;
  frame.height_px =
      static_cast<int>(std::ceil(frame.path_top_row + frame.path_rows + preset.width_px / 2.0));
  return frame;
}

StreakFrame shard_frame(const Preset& preset, const ShardKey& key) {
  if (preset.physical) return physical_frame(preset, key.diameter_um, key.view_elevation_deg);
  return gn2006_frame(preset, key.view_elevation_deg);
}

SizeRecord size_of(const Preset& preset, int diameter_um) {
  if (!preset.physical) {
    return {.diameter_um = diameter_um,
            .mean_radius_m = preset.mean_radius_m,
            .fall_speed_m_s = preset.fall_speed_m_s,
            .span_s = preset.exposure_s,
            .pixel_m = gn2006_frame(preset, 0).pixel_m};
  }
  double reach_m = 0;
  for (const OscillationSet& set : preset.sets) {
    reach_m = std::max(reach_m, drop_reach_m(drop_of(preset, set, diameter_um)));
  }
  return {.diameter_um = diameter_um,
          .mean_radius_m = diameter_um * 0.5e-6,
          .fall_speed_m_s = fall_speed_m_s(diameter_um * 1e-6, preset.physical->air),
          .span_s = preset.physical->span_s,
          .pixel_m = 2 * reach_m / (preset.width_px - 2)};
}

std::vector<int> diameters_of(const Preset& preset) {
  if (preset.physical) return preset.physical->diameters_um;
  return {static_cast<int>(std::lround(2e6 * preset.mean_radius_m))};
}

std::vector<Band> bands_of(const Preset& preset) {
  if (preset.physical) return preset.physical->bands;
  return {{.name = "Y", .refractive_index = preset.field.paths.refractive_index}};
}

DropShape drop_shape(const Preset& preset, int oscillation, double r0_m) {
  const auto diameter_um = static_cast<int>(std::lround(2e6 * r0_m));
  DropShape drop = drop_of(preset, set_of(preset, oscillation), diameter_um);
  drop.mean_radius_m = r0_m;
  if (least_relative_radius(drop) > smallest_relative_radius) return drop;
  const double nearest = minimum_relative_radius(drop, span_of(preset));
  if (nearest > smallest_relative_radius) return drop;
  throw std::runtime_error(fmt::format(
      "set {} at a radius of {} mm: the drop's surface comes as near as {:.3f} r0 to its "
      "centre; expected more than {} r0",
      oscillation, 1e3 * r0_m, nearest, smallest_relative_radius));
}

StreakRequest shard_request(const Preset& preset, const ShardKey& key, int band) {
  StreakRequest request;
  request.drop = drop_of(preset, set_of(preset, key.oscillation), key.diameter_um);
  request.view_elevation_deg = key.view_elevation_deg;
  request.lights = preset.lights;
  request.cone_half_angle_rad = preset.cone_half_angle_deg * std::numbers::pi / 180;
  request.exposure_s = span_of(preset);
  request.frame = shard_frame(preset, key);
  request.field = preset.field;
  request.field.paths.refractive_index =
      bands_of(preset).at(static_cast<std::size_t>(band)).refractive_index;
  request.slices = preset.physical
                       ? slices_needed(*preset.physical, request.drop, request.frame.path_rows)
                       : preset.slices;
  request.spans_per_period = preset.spans_per_period;
  request.motion_tolerance = preset.motion_tolerance;
  request.environment.uniform = preset.environment;
  request.environment.transfer_degree = preset.transfer_degree;
  // A shard's seed follows from its key, so that it can be traced alone and gives the same bytes.
  request.seed = preset.seed * 1000003u + static_cast<std::uint64_t>(key.oscillation) * 1009u +
                 static_cast<std::uint64_t>(key.view_elevation_deg + 90);
  if (preset.physical) request.seed += static_cast<std::uint64_t>(key.diameter_um) * 1000000007u;
  return request;
}

}  // namespace pluvia
