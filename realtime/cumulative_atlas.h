// The atlas as the rain shader reads it: sums down every texel column, so that the mean between any
// two rows is one difference. Exact for every stretch of a streak, and no tap ever mixes two cells.
//
// A level merges 2^level columns of the atlas's finest pictures and keeps all their rows: a tap
// costs the same whatever the length between two rows, so there is nothing to gain from coarser
// ones, and averaged rows would blur the glints along a thin streak. A column of a cell with R rows
// has R + 3 values: C_0 = 0, C_k = sum over the first k rows of the mean over the merged columns,
// summed in double; then centre and half width, in merged columns from its left edge, of the
// uniform strip that has the same mean and variance across as what was merged. A thin streak falls
// on one pixel or its neighbour by where its light is, not by where its cell is. Where column c of
// a cell begins:
//   span.first + (layer (lights + 2) + cell) span.cell_stride + c (R + 3),
// cell = index of the light, then the environment, then coverage.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/streak_atlas.h"

namespace pluvia {

struct CumulativeSpan {  // of one level and view: ivec4 of rain.frag
  std::int32_t first = 0;
  std::int32_t texels = 0;       // R
  std::int32_t cell_stride = 0;  // between cells of this level
  std::int32_t columns = 0;      // texels across a cell
};

struct CumulativeAtlas {
  std::vector<CumulativeSpan> spans = {};  // [level * views + view]; empty for levels left out
  std::vector<float> sums = {};
};

struct LevelRange {
  int finest = 0, coarsest = 0;  // 0 <= finest <= coarsest < atlas.levels; others are left out
};

// environment false: the
// environment's cells stay zero (their pictures may then be missing in the atlas). Throws
// std::runtime_error when a picture is missing or the sums are more than 2^31.
CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, const LevelRange& levels,
                                 bool environment);

}  // namespace pluvia
