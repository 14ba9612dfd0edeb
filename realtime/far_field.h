// The far field: where many streaks cross each pixel, a few of them stand for all.
//
// Of one size, n drops a cubic metre, a streak is L = v exposure long, so seen from the side
//   n L s w / f
// of them cross a pixel within a stretch w of the way at the distance s across the fall (f: focal
// length in px; seen from above or below no fewer do). w is the stretch over which their light
// stays alike: an e-fold of the distance, w = s, or 2 r where a lamp is nearer, r its distance
// across the fall. Where that is more than far_streaks, a cell keeps the share
// q = far_streaks f / (n L s w) of its drops, the first ones, which are as random as any, and each
// counts for 1 / q: q times the number of drops, the last one for what is missing. So the sum of
// what the drops of a cell count for is always their number: the mean of the picture's light and
// optical depth stays, and nothing jumps while the camera moves. What grows is the grain: what a
// stretch adds to a pixel varies by 1 / sqrt(far_streaks) of its mean, instead of by
// 1 / sqrt(n L s w / f); and a glint that is that much brighter is rarer. n includes the density
// map.
//
// Cost: beyond the lamps a size has far_streaks f / L drops for each radian and metre of height and
// e-fold of distance left, however dense the rain and however far the local space.
#pragma once

#include "raytrace/rain_packets.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"

namespace pluvia {

struct KeptDrops {
  double drops = 0;       // of a cell, in its order; the last counts by its fraction
  double counts_for = 1;  // each
};

// Of a cell around the camera at time_s. far_streaks: 0 keeps all, else >= 1.
KeptDrops kept_drops(const Scene& scene, const RainSpace& space, const SizedCell& cell,
                     double far_streaks);

}  // namespace pluvia
