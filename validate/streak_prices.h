// What the approximations of single streaks cost, each switched on alone against the same streaks
// without it. Streaks are traced here: neither database nor atlas is needed.
//
// Where both sides come from one tracer with one seed, its grid is the same on both, so that its
// noise cancels but for what the approximation changes.
#pragma once

#include <vector>

#include "raytrace/brute_force.h"
#include "raytrace/environment_map.h"
#include "raytrace/preset.h"
#include "raytrace/streak_tracer.h"
#include "validate/price_tags.h"

namespace pluvia {

// The streak of a set (of preset.sets) that the preset would put into a database, but seen from
// any elevation, under these lights and without other pictures. view_elevation_deg 0 .. 80.
StreakRequest streak_of(const Preset& preset, int oscillation, double view_elevation_deg,
                        const std::vector<LightDirection>& lights);

// One for every light.
std::vector<StreakSums> light_sums(const std::vector<StreakImage>& ours,
                                   const std::vector<StreakImage>& truth);

// Light of 0 .. `order` segments inside the drop for each of `orders`, against 0 .. most_order.
std::vector<PriceTag> order_prices(const std::vector<StreakRequest>& streaks,
                                   const std::vector<int>& orders, int most_order);

// The mean of both polarisations' shares at every interface, instead of light that stays polarised
// from one to the next: both by brute force with the same rays.
PriceTag polarisation_price(const std::vector<StreakRequest>& streaks, const BruteOptions& options);

// A rigid sphere of the same radius instead of the oscillating drop.
PriceTag sphere_price(const std::vector<StreakRequest>& streaks);

// One index, the mean of those of the bands, for all of them: streaks are priced band by band, each
// under light of one unit. Index by wavelength: rgb_bands() of raytrace/physical_rain.h, water
// of 20 C.
PriceTag dispersion_price(const std::vector<StreakRequest>& streaks);

// The tracer against itself with another seed: what the other prices cannot be told from.
PriceTag tracer_price(const std::vector<StreakRequest>& streaks);

// Coverage, spread evenly over the rectangle that the drop's sphere passes in the exposure (from
// the centre's first row to its last, 2 r0 wide) instead of drop by row: by the rule of 2006, alpha
// = 2 r0 / path (Garg and Nayar), and as the same area as the truth's. What is priced is the light
// that a streak hides of an even background.
std::vector<PriceTag> coverage_prices(const std::vector<StreakRequest>& streaks);

// Streaks under an environment map, seen as spherical harmonics of degrees 0 .. most_degree (cut at
// 0, as a renderer does), against the same under the map itself, for so many headings of the
// camera, evenly round the circle. map: as EnvironmentMap::radiance, three channels; its
// world_from_drop is not heeded.
std::vector<PriceTag> sky_prices(const std::vector<StreakRequest>& streaks, const Image& map,
                                 int headings, int most_degree);

}  // namespace pluvia
