// One streak picture spread over screen pixels by exact areas.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "raytrace/streak_placement.h"

namespace pluvia {

// Red, green, blue and coverage.
using StreakValue = Eigen::Vector4d;

struct StreakPicture {                   // one view's cell, lit
  int width = 0, height = 0;             // texels
  double path_top_row = 0;               // cell row of the drop's centre at shutter-open
  double path_rows = 0;                  // to the row of its centre at shutter-close, > 0
  std::vector<StreakValue> values = {};  // width * height, row by row
};

// The pixels x0 <= x < x0 + width, y0 <= y < y0 + height of a screen.
struct Footprint {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<StreakValue> values = {};  // width * height; all zero to begin with
};

// All pixels of a screen that any of the pictures may touch; empty when they lie outside.
Footprint empty_footprint(const StreakPlacement& placement,
                          const std::vector<StreakPicture>& pictures, int screen_width,
                          int screen_height);

// Adds the picture's integral over every pixel of the footprint; what falls outside is dropped.
void add_streak(const StreakPlacement& placement, const StreakPicture& picture,
                Footprint& footprint);

}  // namespace pluvia
