// The highest surface of a scene seen against a fall, on a regular grid over the plane across it:
// where drops end. The renderer uploads this very grid, so that both decide alike which drops
// exist.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "raytrace/fall_frame.h"
#include "raytrace/scene.h"

namespace pluvia {

struct PlaneRect {  // in a frame's x, y; empty where a minimum is not below its maximum
  double min_x_m = 0, min_y_m = 0, max_x_m = 0, max_y_m = 0;
};

constexpr double steepest_slope = 4;

struct TopTexel {
  float z_m = -1e30f;  // of the surface, at the texel's centre; -1e30 where there is none
  float slope_x = 0, slope_y = 0;  // of the triangle there; 0 for a steeper one, whose height
};                                 // at the centre stands for the texel

struct TexelRect {  // x0 .. x1 - 1, y0 .. y1 - 1
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

struct TopPatch {  // the texels of a rectangle, row by row, as they were before something covered
                   // them
  TexelRect rect = {};
  std::vector<TopTexel> under = {};
};

struct TopHeight {                  // x, y and heights are those of the frame
  double min_x_m = 0, min_y_m = 0;  // corner of texel (0, 0)
  double texel_m = 0.1;
  int width = 0, height = 0;          // along x, y
  std::vector<TopTexel> texels = {};  // row by row (y)
  double lowest_m = 0;                // of the heights that are; 0 without any
  FallFrame frame = {};
  std::vector<TopPatch> covered = {};  // by each moving part (raytrace/scene_tops.h)
};

// The plane of the highest triangle that touches each texel, by rasterising every triangle
// conservatively: a texel that a roof covers in part is all under the roof. So no drop is ever seen
// under a roof, and beside one drops end up to a texel early. Those along the fall have no top.
// Exact over all of a texel that one plane fills. The grid starts at the rectangle's low corner and
// covers it; an empty rectangle gives no texels; texel_m > 0. Throws std::runtime_error for a grid
// of more than 2^26 texels. index_count: only so many of the mesh's indices.
TopHeight top_height(const Mesh& mesh, const FallFrame& frame, const PlaneRect& rect,
                     double texel_m,
                     std::size_t index_count = std::numeric_limits<std::size_t>::max());

// Rasterises more triangles of a mesh on top, as if they had come after those that are there:
// indices first .. first + count - 1. What they may have covered. lowest_m stays.
TopPatch cover(TopHeight& top, const Mesh& mesh, std::size_t first, std::size_t count);

// Takes the latest cover away again.
void uncover(TopHeight& top, const TopPatch& patch);

// The texel that contains (x, y); nullptr outside the grid.
const TopTexel* texel_at(const TopHeight& top, double x_m, double y_m);

// The plane of the texel that contains (x, y); -1e30 outside the grid and where there is no
// surface.
double height_at(const TopHeight& top, double x_m, double y_m);

}  // namespace pluvia
