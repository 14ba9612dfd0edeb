// What the grid of a database costs between its directions: streaks looked up by the rule of
// atlas/atlas_lookup.h from pictures of the grid's lights and views, against streaks traced at the
// very directions.
//
// All views of a drop are traced in one frame, that of the request: what is compared is light by
// column and by moment of the fall, which is what is left when a renderer stretches a cell to the
// length of its streak.
#pragma once

#include <vector>

#include "atlas/atlas_lookup.h"
#include "raytrace/streak_tracer.h"
#include "validate/price_tags.h"

namespace pluvia {

// So many directions evenly over the sphere's half of azimuths 0 .. 180 (a Fibonacci lattice), in
// whole degrees, none of which light_grid(5) has.
std::vector<LightDirection> lights_between(int count);

struct LitView {
  int elevation_deg = 0;
  std::vector<StreakImage> pictures = {};  // of every light of the grid
};

// Pictures of one drop that is its own mirror image (mirrored_oscillation): lights beyond the
// azimuths of the grid are its pictures, columns flipped.
struct PictureGrid {
  int width_px = 0;
  std::vector<LightDirection> lights = {};
  std::vector<LitView> views = {};  // ascending, of pictures of one size
};

// Of every view and light of `grid`, those lights that `lights` names. Throws std::invalid_argument
// for one that it does not have.
PictureGrid part_of(const PictureGrid& grid, const std::vector<LightDirection>& lights);

// The picture that a renderer mixes for those directions: view_elevation_deg 0 .. 90,
// light_elevation_deg -90 .. 90, light_azimuth_deg any.
std::vector<float> looked_up(const PictureGrid& grid, double view_elevation_deg,
                             double light_elevation_deg, double light_azimuth_deg, LookupMode mode);

// Lights: one trace of `request` with the lights of light_grid(least_step_deg) and `between`
// serves all grids; a tag for each step and mode nearest (view_linear is the same for one view) and
// trilinear. least_step_deg: 20, 10 or 5.
std::vector<PriceTag> light_grid_prices(const std::vector<StreakRequest>& streaks,
                                        int least_step_deg,
                                        const std::vector<LightDirection>& between);

// Views: the request's own lights, seen from `between` (0 .. most_view_deg) and from the grids of
// 20, 10 .. least_step_deg; nearest view, and linear between two.
std::vector<PriceTag> view_grid_prices(const std::vector<StreakRequest>& streaks,
                                       int least_step_deg, const std::vector<int>& between_deg,
                                       int most_view_deg);

// Bytes of pictures of an atlas of so many sets, in floats, with those steps between lights and
// between views 0 .. 80; finest level alone. cell_px: pixels of the cell of view 0.
double atlas_bytes(int sets, int light_step_deg, int view_step_deg, double cell_px);

}  // namespace pluvia
