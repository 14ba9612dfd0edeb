// From directions to cells of the atlas: one rule for every reader. realtime/shaders has the same
// rule in GLSL, tested against this one.
#pragma once

#include "atlas/streak_atlas.h"

namespace pluvia {

// Azimuth and view as the database files them. Azimuth beyond 180 degrees is the left-right mirror
// of the azimuth below it FOR THE MIRRORED DROP (sets 2 and 4, 6 and 8 swap; the others are their
// own mirror).
struct FoldedAngles {
  double view_elevation_deg =
      0;  // >= 0: the 2006 database has no views from below; e < 0 is served as
  double light_elevation_deg = 0;  // (|e|, -v), rows kept
  double light_azimuth_deg = 0;    // 0..180
  int oscillation = 0;             // after the swap
  bool mirrored = false;           // flip the picture's columns
};

// view_elevation in -90..90, light_elevation in -90..90, light_azimuth any, degrees.
FoldedAngles fold_angles(double view_elevation_deg, double light_elevation_deg,
                         double light_azimuth_deg, int oscillation);

// Two neighbouring views with weights that sum to 1 (linear in elevation; beyond the last view:
// that view alone), and the nearest light direction (smallest angle between directions; ties: lower
// index).
struct CellChoice {
  int view[2] = {0, 0};
  double view_weight[2] = {1, 0};
  int light = 0;
};

CellChoice choose_cells(const StreakAtlas& atlas, const FoldedAngles& angles);

}  // namespace pluvia
