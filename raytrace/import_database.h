// The layout of 2006 (atlas/gn2006_layout.h) read back into a database.
#pragma once

#include <string>

#include "atlas/gn2006_layout.h"
#include "raytrace/preset.h"

namespace pluvia {

// Reads the 32 px wide pictures and the factors below `layout` (the smaller sizes are averages of
// them) and writes a database, whole or not at all (atlas/atomic_folder.h). The layout may lack
// views; of each view that its environment factors name, every picture must be there. Returns the
// number of shards.
//
// What pictures do not tell comes from the preset, which must be of a single size: radius, fall and
// exposure, and the oscillation sets, from whose outline the coverage is computed
// (raytrace/drop_silhouette.h). `level` is what the pictures' brightness means; a transit's is
// multiplied by max(coverage). Y.variance holds the rounding to 16 bits alone, (step^2) / 12: the
// noise of whoever made the pictures is not told. The manifest says all of this: preset
// "gn2006-import", seed 0.
//
// Throws std::runtime_error "FILE:LINE:COL: found; expected" for the texts, "FILE: .." for pictures
// (missing, not 16-bit grey, of another size than the preset's, not black with a factor of 0);
// std::invalid_argument for an oscillation that is none of the preset's sets.
int import_gn2006(const std::string& layout, const std::string& out, Preset preset,
                  StreakLevel level);

}  // namespace pluvia
