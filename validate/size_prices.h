// What the pictures of one drop size cost when they stand for another: by the rule of 2006, which
// is that of raytrace/streak_placement.h, a picture made larger or smaller is put one after the
// other (or cut off) as often as its mode of degree 2 has periods in the exposure; modes of other
// degrees do not close.
#pragma once

#include <vector>

#include "raytrace/streak_tracer.h"
#include "validate/price_tags.h"

namespace pluvia {

// The request of the same drop with another radius: as many pixels wide, its fall speed goes with
// the root of the radius (garg_nayar_fall_speed_m_s), the same exposure. radius_m > 0.
StreakRequest of_radius(const StreakRequest& request, double radius_m);

// Periods of its mode of degree 2 for one of the known drop's: (r_known / r)^1.5.
double pictures_in_exposure(const StreakRequest& known, const StreakRequest& wanted);

// The picture of `known` in the frame of `wanted`, `pictures` times (> 0, a fraction at the end cut
// off where the shutter closes), each row by its share of flux (cell_row).
std::vector<float> repeated(const StreakImage& picture, const StreakRequest& known,
                            const StreakRequest& wanted, double pictures);

// For each radius: the picture stretched once over the whole path, and repeated, against tracing
// the drop of that radius.
std::vector<PriceTag> size_prices(const std::vector<StreakRequest>& known,
                                  const std::vector<double>& radii_m);

}  // namespace pluvia
