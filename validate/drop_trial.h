// A scene of single drops with its reference, and how far a picture of the same drops is from it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "realtime/rain_renderer.h"
#include "validate/check.h"
#include "validate/drop_by_drop.h"

namespace pluvia {

// Whether the atlas has what the trials ask for: ten sets, the views 0, 20 and 40 degrees, the 74
// lights of 2006 (among others: of a finer grid) and a uniform sky.
bool can_be_judged(const StreakAtlas& atlas);

// All orders, the index and the cone of the preset.
ReferenceOptions reference_options(const Preset& preset);

// So many samples a drop and pass, whatever its size in the picture; nothing but black or one
// radiance is behind the drops, which needs no samples.
ReferenceSettings reference_settings(double samples_per_px);

// Behind the drop, at its side, in front: the three ways in which a lamp makes a streak. Directions
// of the database for drops at bearings that are multiples of 20 degrees.
constexpr std::array<SunDirection, 3> suns_of_database = {{{10, 150}, {30, 110}, {50, 50}}};

// At time 0. The renderer is made when first asked, and remade from then on: what it holds of the
// atlas stays.
Frame rendered(std::optional<RainRenderer>& renderer, const Scene& scene, const StreakAtlas& atlas,
               const RenderOptions& options = {});

struct DropTrial {
  Scene scene = {};
  std::vector<StreakMask> masks = {};
  ReferenceLight truth = {};
};

DropTrial trial_of(const DropsScene& drops, const StreakAtlas& atlas, const Preset& preset,
                   const ReferenceOptions& options, const ReferenceSettings& settings);

// One streak after the other, how far the light is off, less the noise of the reference.
struct Distance {
  double relative_rmse = 0;   // 0 where the noise is as large
  double standard_error = 0;  // of it; where it is 0, what could hide in the noise
  double sum = 1;             // of all light over that of the reference
  double sum_error = 0;
};

// The relative RMSE whose square is the standard error of the squared error: what may hide.
double hidden_in_noise(const Distance& distance);

Distance beyond_noise(const NoisyError& error);
Distance distance_of(const std::vector<StreakFlux>& fluxes);

// value: the distance's relative RMSE.
Check check_of(const std::string& name, const Distance& distance, double bound,
               const std::string& why);

}  // namespace pluvia
