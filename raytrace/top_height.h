// The highest surface of a scene seen from above, on a regular grid over the rain's box: where
// drops end. The renderer uploads this very grid, so that both decide alike which drops exist.
#pragma once

#include <vector>

#include "raytrace/scene.h"

namespace pluvia {

struct TopHeight {
  double min_x_m = 0, min_y_m = 0;  // corner of texel (0, 0)
  double texel_m = 0.1;
  int width = 0, height = 0;    // texels along x, y
  std::vector<float> z_m = {};  // row by row (y), the surface's height at the texel's centre;
};                              // -1e30 where there is none

// Exact at texel centres: the highest triangle over each, by rasterising every triangle (edges
// belong to it, vertical ones have no top). The grid starts at the box's low corner and covers it;
// texel_m > 0. Throws std::runtime_error for a grid of more than 2^26 texels.
TopHeight top_height(const Mesh& mesh, const Rain& rain, double texel_m);

// The texel that contains (x, y), no interpolation; -1e30 outside the grid.
double height_at(const TopHeight& top, double x_m, double y_m);

}  // namespace pluvia
