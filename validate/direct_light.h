// The light of single drops (validate/drop_by_drop.h) by two roads beside real time and reference:
// traced for the very directions from which each drop is seen and lit, as a database without a grid
// would have it, and looked up in an atlas without a renderer. Between the two lies what the
// atlas's grid costs, and nothing else.
#pragma once

#include "atlas/atlas_lookup.h"
#include "raytrace/preset.h"
#include "validate/drop_by_drop.h"

namespace pluvia {

// Orders and index are the preset's, time and field those of an accuracy level
// (raytrace/streak_accuracy.h). Every light is one of the scene's suns, in one channel. Throws
// std::runtime_error for a drop that is not in view, and where the light's angles are no whole
// degrees to 1e-6.
DropLight direct_light(const Scene& scene, const StreakAtlas& atlas, const Preset& preset,
                       int accuracy_level);

// The light of the cells that atlas/atlas_lookup.h names, by their weights; the flux of a cell does
// not depend on how it is stretched. The atlas's layers are the sets 0, 1, ..
DropLight looked_up_light(const Scene& scene, const StreakAtlas& atlas, LookupMode mode);

}  // namespace pluvia
