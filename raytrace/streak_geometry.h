// What placement (raytrace/streak_placement.h) needs of an atlas: one rule for whoever draws
// streaks of it and whoever judges them.
#pragma once

#include "atlas/streak_atlas.h"
#include "raytrace/streak_placement.h"

namespace pluvia {

// The atlas has one view or more.
StreakGeometry streak_geometry(const StreakAtlas& atlas);

}  // namespace pluvia
