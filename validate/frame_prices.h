// What the approximations of frames cost, each switched on alone: drawing, against the exact
// composite of the same drops; what a drop's surroundings are taken for, against the reference
// tracer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "atlas/streak_atlas.h"
#include "raytrace/preset.h"
#include "raytrace/scene.h"
#include "validate/drop_trial.h"
#include "validate/price_tags.h"
#include "validate/report.h"
#include "validate/streak_flux.h"

namespace pluvia {

// A picture in squares of side_px (those at the right and lower edge may be smaller), each as if it
// were a streak, all channels together.
std::vector<StreakSums> square_sums(const Image& ours, const Image& truth, int side_px);

// Rain layers of a frame, in squares of 20 px, against the exact composite of all its drops: as the
// renderer draws by default, quads alone, coarser texels; and the same of rain eight times as
// dense, where streaks hide each other more often, whole and by few far streaks for many. The scene
// is without splashes, lens and shadows (validate/frame_composite.h).
std::vector<PriceTag> drawing_prices(const Scene& scene, const StreakAtlas& atlas);

// One row of a table of distances.
struct DistanceTag {
  std::string approximation = {}, against = {};
  Distance distance = {};
};
Table distance_table(const std::string& title, const std::vector<DistanceTag>& tags);

// One view and one direction of light for the whole of a streak, although a near drop falls through
// many: single drops of two sets, 6 to 0.3 m away, under three suns, in the middle of the streak
// from directions that the database holds; real time against the reference with its orders.
std::vector<DistanceTag> near_drop_prices(const StreakAtlas& atlas, const Preset& preset);

// A lamp taken as a direction and an illuminance, those at the middle of a drop's path, and not as
// the place that it is: reference against reference, lamps 4 to 0.25 m from the path's middle.
std::vector<DistanceTag> near_lamp_prices(const StreakAtlas& atlas, const Preset& preset);

// For each distance [m, > 0] the streaks of two sets under three lamps, as directions (measured)
// and where they are (truth), with the noise of both. The two sides have seeds of their own: with
// one seed their noise would be the same in part, and less of it in the difference than is taken
// away. So with lamps that are very far the difference is noise of the stated size.
std::vector<std::vector<StreakFlux>> near_lamp_fluxes(const StreakAtlas& atlas,
                                                      const Preset& preset,
                                                      const std::vector<double>& lamps_m,
                                                      double samples_per_px);

// A whole frame of some 600 drops, 250 of them in view, 1 to 7 m before the camera under the map of
// a city and a sun, 320 x 180 pixels, no surface. All its drops are near: the reference needs a
// minute, not hours.
Scene small_frame(const StreakAtlas& atlas, const std::string& data_folder);

// The same rain at night: under three lamps, behind it, beside it and behind the camera, and the
// map a thousandth as bright.
Scene small_night_frame(const StreakAtlas& atlas, const std::string& data_folder);

// The same sky and sun, and the same lamps, through a long lens: about a dozen drops 0.15 to 0.6 m
// before it, 240 x 135 pixels, streaks 5 to 18 pixels wide.
Scene near_frame(const StreakAtlas& atlas, const std::string& data_folder);
Scene near_night_frame(const StreakAtlas& atlas, const std::string& data_folder);

struct ReferenceFrame {
  Image rain = {};      // RGB
  Image variance = {};  // of it
  Image coverage = {};  // 1 channel
};
// passes >= 2, besides four that learn.
ReferenceFrame reference_frame(const Scene& scene, const StreakAtlas& atlas,
                               const ReferenceOptions& options, const Preset& preset,
                               double samples_per_px, int passes, std::uint64_t seed = 1);

// Of two that were traced with other seeds and as many passes.
ReferenceFrame mean_of(const ReferenceFrame& a, const ReferenceFrame& b);

// Relative standard error of its rain: sqrt(sum v / (sum b^2 - sum v)).
double noise_of(const ReferenceFrame& frame);

// A background with a layer of rain over it, so many times as strong as it is; 0 where that is
// below.
Image with_rain(const Image& background, const Image& rain, float gain);

// Rain layer of a real-time frame against it, pixel by pixel, less the noise; sum: of all light.
Distance frame_distance(const Image& rain, const ReferenceFrame& truth);

}  // namespace pluvia
