#include "raytrace/scene_subset.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "raytrace/spherical_harmonics.h"

namespace pluvia {

namespace {

template <typename Value, typename Name>
SubsetRow row_of(const std::string& what, const std::vector<Value>& all,
                 const std::vector<Value>& kept, Name name) {
  SubsetRow row = {.what = what};
  for (const Value& value : all) {
    const bool in = std::find(kept.begin(), kept.end(), value) != kept.end();
    std::string& names = in ? row.kept : row.left_out;
    names += (names.empty() ? "" : ", ") + name(value);
  }
  return row;
}

// The diameters nearest to each size of the scene's drops: the same, or its two neighbours in the
// list, or its end.
std::vector<int> needed_diameters(const std::vector<int>& known_um, const Scene& scene) {
  std::vector<RainSize> sizes = scene.rain.sizes;
  for (const SingleDrop& drop : scene.drops) sizes.push_back({.r0_m = drop.r0_m});
  std::set<int> needed;
  for (const RainSize& size : sizes) {
    const double wanted_um = 2e6 * size.r0_m;
    const auto above = std::lower_bound(known_um.begin(), known_um.end(), wanted_um - 1e-3);
    if (above == known_um.end() || above == known_um.begin()) {
      needed.insert(above == known_um.end() ? known_um.back() : known_um.front());
      continue;
    }
    needed.insert(*above);
    if (*above > wanted_um + 1e-3) needed.insert(*(above - 1));
  }
  return {needed.begin(), needed.end()};
}

bool has_environment(const EnvironmentLight& environment) {
  return environment.map_file.empty() ? (environment.uniform_cd_m2.array() > 0).any()
                                      : environment.scale_cd_m2 > 0;
}

// Whether anything shines in that band. Only R, G and B tell which of a scene's colours they are.
bool is_lit(const Band& band, const Scene& scene) {
  const auto channel = std::string("RGB").find(band.name);
  if (band.name.size() != 1 || channel == std::string::npos) return true;
  const auto c = static_cast<Eigen::Index>(channel);
  const EnvironmentLight& environment = scene.environment;
  if (has_environment(environment) &&
      (!environment.map_file.empty() || environment.uniform_cd_m2[c] > 0)) {
    return true;
  }
  return std::any_of(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
    return light.intensity_cd[c] > 0 || light.illuminance_lux[c] > 0;
  });
}

void reduce_physical(PhysicalRain& rain, const Scene& scene) {
  rain.diameters_um = needed_diameters(rain.diameters_um, scene);
  const auto dark = [&](const Band& band) { return !is_lit(band, scene); };
  if (!std::all_of(rain.bands.begin(), rain.bands.end(), dark)) std::erase_if(rain.bands, dark);
}

long transfer_parts(const Preset& preset) {
  return preset.transfer_degree < 0 ? 0 : static_cast<long>(harmonic_count(preset.transfer_degree));
}

void count_images(const Preset& preset, long& images, long& shards, long& tracings) {
  const auto bands = static_cast<long>(bands_of(preset).size());
  const long parts = static_cast<long>(preset.lights.size()) + (preset.environment ? 1 : 0) +
                     transfer_parts(preset);
  shards = static_cast<long>(diameters_of(preset).size() * preset.oscillations.size() *
                             preset.view_elevations_deg.size());
  tracings = shards * bands;
  images = shards * (parts * bands + 1);
}

std::vector<SubsetRow> rows_of(const Preset& all, const Preset& kept) {
  const auto degrees = [](int view) { return fmt::format("{:+d}", view); };
  const auto millimetres = [](int um) { return fmt::format("{}", um / 1000.0); };
  const auto name = [](const Band& band) { return band.name; };
  std::vector<SubsetRow> rows = {
      row_of("views", all.view_elevations_deg, kept.view_elevations_deg, degrees),
      row_of("lights", all.lights, kept.lights, light_name),
      row_of("sizes", diameters_of(all), diameters_of(kept), millimetres),
      row_of("bands", bands_of(all), bands_of(kept), name)};
  if (all.environment) {
    rows.push_back({.what = "environment",
                    .kept = kept.environment ? "env" : "",
                    .left_out = kept.environment ? "" : "env"});
  }
  if (all.transfer_degree >= 0) {
    const std::string degree = fmt::format("degree {}", all.transfer_degree);
    const bool stays = kept.transfer_degree >= 0;
    rows.push_back(
        {.what = "transfer", .kept = stays ? degree : "", .left_out = stays ? "" : degree});
  }
  return rows;
}

}  // namespace

SceneSubset scene_subset(const Preset& preset, const Scene& scene, const std::string& scene_file) {
  if (scene.rain.sizes.empty() && scene.drops.empty())
    throw std::runtime_error(scene_file + ": no rain; expected [rain] with drops, or a [[drop]]");
  SceneSubset subset = {.preset = preset};
  Preset& kept = subset.preset;
  if (kept.physical) {
    reduce_physical(*kept.physical, scene);
    kept.field.paths.refractive_index = kept.physical->bands.front().refractive_index;
  }
  kept.environment = preset.environment && has_environment(scene.environment);
  // A uniform environment needs no harmonics.
  if (!kept.environment || scene.environment.map_file.empty()) kept.transfer_degree = -1;
  const Reach reach = scene_reach(kept, scene);
  if (reach.views_deg.empty()) {
    throw std::runtime_error(
        scene_file + ": no drop of the rain can be seen; expected rain in the camera's view");
  }
  kept.view_elevations_deg = reach.views_deg;
  kept.lights = reach.lights;
  if (kept.lights.empty()) kept.lights = {preset.lights.front()};
  subset.rows = rows_of(preset, kept);
  count_images(preset, subset.all_images, subset.all_shards, subset.all_tracings);
  count_images(kept, subset.images, subset.shards, subset.tracings);
  return subset;
}

}  // namespace pluvia
