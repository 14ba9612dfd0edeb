#include "raytrace/preset.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atlas/atlas_lookup.h"
#include "raytrace/toml_reader.h"

namespace pluvia {

namespace {

constexpr double drop_radius_px_of_16 = 5.6;
constexpr double path_top_px_of_16 = 9;

DropShape drop_of(const Preset& preset, const OscillationSet& set) {
  DropShape drop;
  drop.mean_radius_m = preset.mean_radius_m;
  drop.density_kg_m3 = preset.density_kg_m3;
  drop.surface_tension_n_m = preset.surface_tension_n_m;
  drop.phi_drop_rad = set.phi_drop_deg * std::numbers::pi / 180;
  if (set.a20 != 0) drop.modes.push_back({.n = 2, .m = 0, .amplitude = set.a20});
  if (set.a31 != 0) drop.modes.push_back({.n = 3, .m = 1, .amplitude = set.a31});
  return drop;
}

OscillationSet read_set(TomlReader& table, const Preset& preset) {
  OscillationSet set;
  table.required("index", set.index, 0, 99);
  table.required("A20", set.a20, {-1, 1});
  table.required("A31", set.a31, {-1, 1});
  table.required("phi_drop_deg", set.phi_drop_deg, {-360, 360}, "deg");
  table.finish();
  for (const OscillationSet& other : preset.sets) {
    if (other.index == set.index) {
      table.refuse("index", fmt::format("index = {} again; expected each index once", set.index));
    }
  }
  const double nearest = minimum_relative_radius(drop_of(preset, set), preset.exposure_s);
  if (!(nearest > smallest_relative_radius)) {
    table.refuse("A20", fmt::format("set {}: the drop's surface comes as near as {:.3f} r0 to its "
                                    "centre; expected more than {} r0 (smaller A20, A31)",
                                    set.index, nearest, smallest_relative_radius));
  }
  return set;
}

// Lights beyond azimuth 180 are served by the mirrored drop (atlas/atlas_lookup.h): each set's
// mirror image must be the set that the rule names.
void refuse_wrong_mirrors(const std::string& file, const Preset& preset) {
  for (const OscillationSet& set : preset.sets) {
    if (set.a31 == 0) continue;
    const int partner = fold_angles(0, 0, -90, set.index).oscillation;
    const auto other = std::find_if(preset.sets.begin(), preset.sets.end(),
                                    [&](const OscillationSet& s) { return s.index == partner; });
    const bool mirrors =
        other != preset.sets.end() && other->a20 == set.a20 && other->a31 == set.a31 &&
        std::abs(std::remainder(other->phi_drop_deg + set.phi_drop_deg, 360)) < 1e-9;
    if (!mirrors) {
      throw std::runtime_error(
          fmt::format("{}: set {}: its left-right mirror image is not set {}; expected there A20 = "
                      "{}, A31 = {}, "
                      "phi_drop_deg = {}",
                      file, set.index, partner, set.a20, set.a31, -set.phi_drop_deg));
    }
  }
}

// Needs the preset's drop and exposure, which decide how thin the drops of the sets become.
void read_sets(const std::string& file, Preset& preset) {
  const toml::table document = read_toml(file);
  TomlReader top(document, file, "");
  for (TomlReader& table : top.tables("set")) preset.sets.push_back(read_set(table, preset));
  top.finish();
  if (preset.sets.empty()) {
    throw std::runtime_error(file + ":1:1: no [[set]]; expected at least one oscillation set");
  }
  refuse_wrong_mirrors(file, preset);
}

void read_accuracy(TomlReader accuracy, Preset& preset) {
  accuracy.required("slices", preset.slices, 1, 1000000);
  accuracy.required("spans_per_period", preset.spans_per_period, {0, 1000, true});
  accuracy.required("base_cells", preset.field.base_cells, 2, 256);
  accuracy.required("space_depth", preset.field.space_depth, 0, 8);
  accuracy.required("time_depth", preset.field.time_depth, 0, 8);
  accuracy.required("bend_tolerance", preset.field.bend_tolerance, {0, 10, true});
  accuracy.finish();
}

void read_drop(TomlReader drop, Preset& preset) {
  drop.required("mean_radius_m", preset.mean_radius_m, {1e-5, 1e-2}, "m");
  drop.required("density_kg_m3", preset.density_kg_m3, {1, 1e5}, "kg/m^3");
  drop.required("surface_tension_n_m", preset.surface_tension_n_m, {0, 10, true}, "N/m");
  drop.required("refractive_index", preset.field.paths.refractive_index, {1, 4});
  drop.finish();
}

void read_picture(TomlReader picture, Preset& preset) {
  picture.required("width_px", preset.width_px, 4, 64);
  if ((preset.width_px & (preset.width_px - 1)) != 0) {
    picture.refuse("width_px",
                   fmt::format("width_px = {}; expected a power of two", preset.width_px));
  }
  picture.optional("view_elevations_deg", preset.view_elevations_deg, 0, 80);
  picture.optional("oscillations", preset.oscillations, 0, 99);
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

// The heights are those of the published pictures: a longer fall would be cut off at their last
// row.
void refuse_long_fall(const TomlReader& exposure, const Preset& preset) {
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
  if (preset.name != "gn2006") {
    top.refuse("preset", fmt::format("preset = \"{}\"; expected \"gn2006\"", preset.name));
  }
  top.required("oscillation_file", oscillation_file);
  top.optional("seed", preset.seed);
  read_drop(top.table("drop"), preset);
  TomlReader exposure = top.table("exposure");
  exposure.required("exposure_s", preset.exposure_s, {0, 1, true}, "s");
  exposure.required("fall_speed_m_s", preset.fall_speed_m_s, {0, 20, true}, "m/s");
  exposure.finish();
  read_sets(path_beside(file, oscillation_file), preset);
  TomlReader light = top.table("light");
  light.required("cone_half_angle_deg", preset.cone_half_angle_deg, {0.05, 30}, "deg");
  light.required("max_order", preset.field.paths.max_order, 0, 20);
  light.finish();
  read_picture(top.table("picture"), preset);
  refuse_long_fall(exposure, preset);
  read_accuracy(top.table("accuracy"), preset);
  top.finish();
  return preset;
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
  nlohmann::json sets = nlohmann::json::array();
  for (const OscillationSet& set : preset.sets) {
    sets.push_back({{"index", set.index},
                    {"A20", set.a20},
                    {"A31", set.a31},
                    {"phi_drop_deg", set.phi_drop_deg}});
  }
  const nlohmann::json parameters = {{"oscillation_sets", sets},
                                     {"tracer_version", tracer_version},
                                     {"mean_radius_m", preset.mean_radius_m},
                                     {"density_kg_m3", preset.density_kg_m3},
                                     {"surface_tension_n_m", preset.surface_tension_n_m},
                                     {"refractive_index", preset.field.paths.refractive_index},
                                     {"max_order", preset.field.paths.max_order},
                                     {"min_power", preset.field.paths.min_power},
                                     {"exposure_s", preset.exposure_s},
                                     {"fall_speed_m_s", preset.fall_speed_m_s},
                                     {"cone_half_angle_deg", preset.cone_half_angle_deg},
                                     {"width_px", preset.width_px},
                                     {"slices", preset.slices},
                                     {"spans_per_period", preset.spans_per_period},
                                     {"base_cells", preset.field.base_cells},
                                     {"space_depth", preset.field.space_depth},
                                     {"time_depth", preset.field.time_depth},
                                     {"bend_tolerance", preset.field.bend_tolerance}};
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
                    std::cos(view_elevation_deg * std::numbers::pi / 180) / frame.pixel_m;
  return frame;
}

StreakRequest shard_request(const Preset& preset, const ShardKey& key) {
  StreakRequest request;
  request.drop = drop_of(preset, set_of(preset, key.oscillation));
  request.view_elevation_deg = key.view_elevation_deg;
  request.lights = gn2006_light_directions();
  request.cone_half_angle_rad = preset.cone_half_angle_deg * std::numbers::pi / 180;
  request.exposure_s = preset.exposure_s;
  request.frame = gn2006_frame(preset, key.view_elevation_deg);
  request.field = preset.field;
  request.slices = preset.slices;
  request.spans_per_period = preset.spans_per_period;
  // A shard's seed follows from its key, so that it can be traced alone and gives the same bytes.
  request.seed = preset.seed * 1000003u + static_cast<std::uint64_t>(key.oscillation) * 1009u +
                 static_cast<std::uint64_t>(key.view_elevation_deg + 90);
  return request;
}

}  // namespace pluvia
