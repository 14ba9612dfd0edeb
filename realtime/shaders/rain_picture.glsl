// What every way of drawing a streak has in common.
#include "rain_uniforms.glsl"

// raytrace/streak_placement.h
float cell_row(float row, float path_rows, float cell_path_rows) {
  if (row <= cell.x) return row;
  if (row >= cell.x + path_rows) return row - path_rows + cell_path_rows;
  return cell.x + (row - cell.x) / path_rows * cell_path_rows;
}

// -log(1 - c), c the share of pixel and exposure that is covered. c = 1 would be a drop that stands
// still before the whole pixel; 14 optical depths hide the background as well as infinity does.
const float most_coverage = 1.0 - 1e-6;

float optical_depth(float c) {
  if (c < 0.03) return c * (1.0 + c * (0.5 + c * (1.0 / 3.0 + c * 0.25)));  // 1 - c would round c
  return -log(1.0 - min(c, most_coverage));
}

// Of so many streaks side by side that cover c together.
float optical_depth(float c, float streaks) { return streaks * optical_depth(c / streaks); }

float covered(float c, float streaks) { return streaks * min(c / streaks, most_coverage); }

// Of a streak among others: see composite.frag. Never 0, or a pixel of very dense rain would count
// as dry.
float mean_field_weight(float depth_m) {
  return max(exp(-air.y * max(depth_m - air.z, 0.0)), 1e-20);
}
