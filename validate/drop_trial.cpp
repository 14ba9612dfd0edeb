#include "validate/drop_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "validate/checks.h"

namespace pluvia {

bool can_be_judged(const StreakAtlas& atlas) {
  const auto has = [&](int elevation_deg) {
    return std::any_of(atlas.views.begin(), atlas.views.end(),
                       [&](const AtlasView& view) { return view.elevation_deg == elevation_deg; });
  };
  const auto published = light_grid(20);
  const bool lit = std::all_of(published.begin(), published.end(), [&](const LightDirection& l) {
    return std::find(atlas.lights.begin(), atlas.lights.end(), l) != atlas.lights.end();
  });
  return atlas.layers.size() == 10 && has(0) && has(20) && has(40) && lit &&
         !atlas.layers.front().env.empty();
}

ReferenceOptions reference_options(const Preset& preset) {
  return {.refractive_index = bands_of(preset).at(0).refractive_index,
          .cone_half_angle_rad = preset.cone_half_angle_deg * std::numbers::pi / 180};
}

ReferenceSettings reference_settings(double samples_per_px) {
  return {.error = 1e-9,
          .learning_passes = 4,
          .least_passes = 12,
          .most_passes = 12,
          .surface_samples = 1,
          .samples_per_px = samples_per_px};
}

Frame rendered(std::optional<RainRenderer>& renderer, const Scene& scene, const StreakAtlas& atlas,
               const RenderOptions& options) {
  if (renderer)
    renderer->remake(scene, atlas, options);
  else
    renderer.emplace(scene, atlas, options);
  return renderer->render(0);
}

DropTrial trial_of(const DropsScene& drops, const StreakAtlas& atlas, const Preset& preset,
                   const ReferenceOptions& options, const ReferenceSettings& settings) {
  DropTrial trial = {.scene = scene_of(drops, atlas)};
  trial.masks = rectangles_of(trial.scene, atlas);
  trial.truth =
      reference_light(trial.scene, preset, set_numbers(atlas), trial.masks, options, settings);
  return trial;
}

double hidden_in_noise(const Distance& distance) {
  if (distance.relative_rmse == 0) return distance.standard_error;
  return std::sqrt(2 * distance.relative_rmse * distance.standard_error);
}

Distance beyond_noise(const NoisyError& error) {
  if (error.squared <= error.standard_error) return {0, std::sqrt(error.standard_error)};
  const double root = std::sqrt(error.squared);
  return {root, error.standard_error / (2 * root)};
}

Distance distance_of(const std::vector<StreakFlux>& fluxes) {
  Distance distance = beyond_noise(flux_error(fluxes).all);
  double ours = 0, truth = 0, variance = 0;
  for (const StreakFlux& flux : fluxes) {
    ours += flux.measured;
    truth += flux.truth;
    variance += flux.standard_error * flux.standard_error;
  }
  distance.sum = ours / truth;
  distance.sum_error = std::sqrt(variance) / truth;
  return distance;
}

Check check_of(const std::string& name, const Distance& distance, double bound,
               const std::string& why) {
  Check check = deviation(name, distance.relative_rmse, 0, bound, "relative RMSE", why);
  check.uncertainty = distance.standard_error;
  return check;
}

}  // namespace pluvia
