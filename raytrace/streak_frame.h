// The picture of a streak: where the drop is in it at each moment, and sums deposited into its
// pixels.
#pragma once

#include <vector>

#include "raytrace/cone_clip.h"

namespace pluvia {

// An orthographic picture of the whole fall. Column and row coordinates are continuous, pixel (i,
// j) covers [i, i+1] x [j, j+1]; the drop's centre stays on centre_column and moves from
// path_top_row at shutter-open to path_top_row + path_rows at shutter-close.
struct StreakFrame {
  int width_px = 32;
  int height_px = 0;
  double pixel_m = 0;
  double centre_column = 16;
  double path_top_row = 0;
  double path_rows = 0;
};

// Pictures of one slice of time, all planes alike, over a window of rows.
struct StreakWindow {
  int first_row = 0;
  int rows = 0;
  int width_px = 0;
  int planes = 0;
  std::vector<double> values = {};  // plane, row, column

  double* row(int plane, int window_row) {
    return values.data() + ((static_cast<std::size_t>(plane) * static_cast<std::size_t>(rows) +
                             static_cast<std::size_t>(window_row)) *
                            static_cast<std::size_t>(width_px));
  }
};

// A window that holds everything a drop of at most radius_m leaves while its centre moves over
// [first_centre_row, last_centre_row].
StreakWindow make_window(const StreakFrame& frame, int planes, double radius_m,
                         double first_centre_row, double last_centre_row);

// The rows that the drop's centre travels during a slice.
struct Travel {
  double first_row = 0, last_row = 0;
};

// Adds polygon's area (in pixels) times mean throughput times weight, spread over the rows that it
// passes during the slice: exact over columns, and over rows exact for the travel and for the
// polygon's own extent as if it were a rectangle. The polygon's x is a column, its y a row relative
// to the centre's. What falls beyond the frame's edges is left out: the frame cuts it.
void deposit(StreakWindow& window, int plane, const Travel& travel, ConePolygon polygon,
             double weight);

}  // namespace pluvia
