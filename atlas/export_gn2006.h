// A database written in the layout of 2006 (atlas/gn2006_layout.h).
#pragma once

#include <string>

#include "atlas/gn2006_layout.h"

namespace pluvia {

enum class Normalise {
  shared,  // the smaller pictures are divided by the factor of the 32 px wide one: value x factor
           // is brightness in all sizes
  each     // every picture has a maximum of 65535, as the files of 2006; the texts tell the factors
           // of the 32 px wide ones
};

struct ExportOptions {
  StreakLevel level = StreakLevel::transit;
  Normalise normalise = Normalise::shared;
  int diameter_um = 0;    // 0: the only one
  std::string band = {};  // a name; empty: the only one, or luminance (atlas/streak_atlas.h)
};

struct ExportSummary {
  int pictures = 0;
  int shards_left_out = 0;  // other views, oscillations and diameters: the layout has no place
};

// The picture of a factor: its own value at the brightest pixel of the 32 px wide picture, 65535
// there and at most half a step off elsewhere. The smaller sizes are area averages of that picture,
// heights rounded up, nothing beyond its last row. A wider database is averaged down to 32 px
// first.
//
// Needs all 50 shards (ten oscillations at five views) with env and the 74 lights, a width of 32 px
// or a power of two above it, one height for each view, no two views alike. OUT appears whole or
// not at all (atlas/atomic_folder.h). Throws std::runtime_error that names what is missing or
// damaged.
ExportSummary export_gn2006(const std::string& database_folder, const std::string& out,
                            const ExportOptions& options = {});

}  // namespace pluvia
