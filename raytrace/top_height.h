// The highest surface of a scene seen against a fall, on a regular grid over the plane across it:
// where drops end. The renderer uploads this very grid, so that both decide alike which drops
// exist.
#pragma once

#include <vector>

#include "raytrace/fall_frame.h"
#include "raytrace/scene.h"

namespace pluvia {

struct PlaneRect {  // in a frame's x, y; empty where a minimum is not below its maximum
  double min_x_m = 0, min_y_m = 0, max_x_m = 0, max_y_m = 0;
};

struct TopTexel {
  float z_m = -1e30f;  // of the surface, at the texel's centre; -1e30 where there is none
  float slope_x = 0, slope_y = 0;  // of the triangle there; 0 for one steeper than 4, whose height
};                                 // at the centre stands for the texel

struct TopHeight {                  // x, y and heights are those of the frame
  double min_x_m = 0, min_y_m = 0;  // corner of texel (0, 0)
  double texel_m = 0.1;
  int width = 0, height = 0;          // along x, y
  std::vector<TopTexel> texels = {};  // row by row (y)
  double lowest_m = 0;                // of the heights that are; 0 without any
};

// The plane of the highest triangle that touches each texel, by rasterising every triangle
// conservatively: a texel that a roof covers in part is all under the roof. So no drop is ever seen
// under a roof, and beside one drops end up to a texel early. Those along the fall have no top.
// Exact over all of a texel that one plane fills. The grid starts at the rectangle's low corner and
// covers it; an empty rectangle gives no texels; texel_m > 0. Throws std::runtime_error for a grid
// of more than 2^26 texels.
TopHeight top_height(const Mesh& mesh, const FallFrame& frame, const PlaneRect& rect,
                     double texel_m);

// The texel that contains (x, y); nullptr outside the grid.
const TopTexel* texel_at(const TopHeight& top, double x_m, double y_m);

// The plane of the texel that contains (x, y); -1e30 outside the grid and where there is no
// surface.
double height_at(const TopHeight& top, double x_m, double y_m);

}  // namespace pluvia
