// Drops, sizes, pictures and requests of a preset's shards.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "raytrace/preset.h"

namespace pluvia {
namespace {

constexpr double drop_radius_px_of_16 = 5.6;
constexpr double path_top_px_of_16 = 9;

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

}  // namespace

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

double mean_refractive_index(const Preset& preset) {
  double sum = 0;
  const std::vector<Band> bands = bands_of(preset);
  for (const Band& band : bands) sum += band.refractive_index;
  return sum / static_cast<double>(bands.size());
}

std::optional<double> too_near_surface(const DropShape& drop, double span_s) {
  if (least_relative_radius(drop) > smallest_relative_radius) return std::nullopt;
  const double nearest = minimum_relative_radius(drop, span_s);
  if (nearest > smallest_relative_radius) return std::nullopt;
  return nearest;
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
  if (const auto nearest = too_near_surface(drop, span_of(preset))) {
    throw std::runtime_error(fmt::format(
        "set {} at a radius of {} mm: the drop's surface comes as near as {:.3f} r0 to its "
        "centre; expected more than {} r0",
        oscillation, 1e3 * r0_m, *nearest, smallest_relative_radius));
  }
  return drop;
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
