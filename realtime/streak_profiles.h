// The atlas as thin streaks need it: across, a streak at most a few pixels wide shows no more than
// where its light is. Of each cell, and of its left half, down the streak: the flux, its place
// across and the square of that.
//
// A level joins 2^(first + level) rows of the atlas's pictures. A cell of R rows has B = ceil(R /
// 2^(first + level)) bins and 2 (B + 1) values of four floats, the last of them 0:
//   value 2 k      F, M, S of the rows before bin k (k = 0 .. B)
//   value 2 k + 1  the same of the left half of the cell
//   F = sum of p / cell width, M = sum of p u / cell width, S = sum of p u^2 / cell width
// p the picture's values, u across the cell, -1/2 .. 1/2, S with the width of a texel; summed in
// double. M / F is where the light is, S / F - (M / F)^2 its variance. Between two rows of a bin
// the light is taken as even. Where a cell begins:
//   span.first + (layer cells_per_layer + cell) span.cell_stride
// cells in the order of finest_cell (atlas/streak_atlas.h).
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/streak_atlas.h"

namespace pluvia {

struct ProfileSpan {  // of one level and view: ivec4 of rain_splat.comp
  std::int32_t first = 0;
  std::int32_t bins = 0;         // B
  std::int32_t cell_stride = 0;  // between cells
  std::int32_t rows = 0;         // R; the last bin may have fewer than the others
};

struct StreakProfiles {
  int first = 0, levels = 0;
  std::vector<ProfileSpan> spans = {};  // [level * views + view]
  std::vector<float> values = {};       // four for each place that spans name
};

// first: of the finest level, >= 0. Levels follow until the longest cell has at most two bins.
// Throws std::runtime_error when a picture is missing.
StreakProfiles streak_profiles(const StreakAtlas& atlas, int first, int sky_cells);

}  // namespace pluvia
