// From directions to cells of the atlas: one rule for every reader. realtime/shaders has the same
// rule in GLSL, tested against this one.
#pragma once

#include <array>
#include <vector>

#include "atlas/streak_atlas.h"

namespace pluvia {

// Azimuth and view as the database files them. Azimuth beyond 180 degrees is the left-right mirror
// of the azimuth below it FOR THE MIRRORED DROP (sets 2 and 4, 6 and 8 swap; the others are their
// own mirror).
struct FoldedAngles {
  double view_elevation_deg = 0;  // see ViewsBelow
  double light_elevation_deg = 0;
  double light_azimuth_deg = 0;  // 0..180
  int oscillation = 0;           // after the swap
  bool mirrored = false;         // flip the picture's columns
};

// What becomes of a view e < 0, from below. The 2006 database has none: e is served as (|e|, -v),
// rows kept. A database with views of its own from below keeps e: such a view is no flip of one
// from above (time order of rows, shape at rest).
enum class ViewsBelow { flipped, own };

// `own` when the atlas's first view is from below.
ViewsBelow views_below(const StreakAtlas& atlas);

// view_elevation in -90..90, light_elevation in -90..90, light_azimuth any, degrees.
FoldedAngles fold_angles(double view_elevation_deg, double light_elevation_deg,
                         double light_azimuth_deg, int oscillation,
                         ViewsBelow below = ViewsBelow::flipped);

// How many cells a streak mixes for one light, of at most two views and four lights.
enum class LookupMode {
  nearest,      // 1: the nearest view and light
  view_linear,  // 2: linear between two views, the nearest light (Creus 2010)
  trilinear     // 8: linear between two views, two light elevations and two azimuths
};

// "nearest", "view-linear", "trilinear": as flags and figures name them.
const char* lookup_name(LookupMode mode);

// Two neighbouring views with weights that sum to 1 (linear in elevation; beyond the last view:
// that view alone), and the nearest light direction (smallest angle between directions; ties: lower
// index).
struct CellChoice {
  int view[2] = {0, 0};
  double view_weight[2] = {1, 0};
  int light = 0;
};

CellChoice choose_cells(const StreakAtlas& atlas, const FoldedAngles& angles);

// The lights of the atlas by elevation, each row by azimuth from 0 to 360: those beyond 180 are
// mirror images of those below it, for the mirrored drop.
struct LightRow {
  struct Entry {
    double azimuth_deg = 0;
    int light = 0;
    bool mirrored = false;
  };
  double elevation_deg = 0;
  std::vector<Entry> entries = {};  // one for a pole
};
std::vector<LightRow> light_rows(const StreakAtlas& atlas);

// Four lights with weights that sum to 1 (some may be 0): linear in elevation between two rows, of
// each the two neighbours in azimuth, round the circle; beyond the last row that row alone.
// mirrored: relative to the folded angles.
struct LightTap {
  int light = 0;
  double weight = 0;
  bool mirrored = false;
};
std::array<LightTap, 4> light_taps(const std::vector<LightRow>& rows, const FoldedAngles& angles);

// The mode's cells: views as choose_cells has them or the nearer alone; one light or four.
struct CellMix {
  int view[2] = {0, 0};
  double view_weight[2] = {1, 0};
  std::array<LightTap, 4> lights = {};
};
CellMix mix_cells(const StreakAtlas& atlas, const std::vector<LightRow>& rows,
                  const FoldedAngles& angles, LookupMode mode);

// The set whose drop is the mirror image (2 and 4, 6 and 8 swap).
int mirrored_oscillation(int oscillation);

}  // namespace pluvia
