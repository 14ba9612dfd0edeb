// The atlas as the rain shader reads it: sums down every texel column, so that the mean between any
// two rows is one difference. Exact for every stretch of a streak, and no tap ever mixes two cells.
//
// A level merges 2^level columns of the atlas's finest pictures and keeps all their rows: a tap costs
// the same whatever the length between two rows, so there is nothing to gain from coarser ones, and
// averaged rows would blur the glints along a thin streak. A column of a cell with R rows has R + 1
// values: C_0 = 0, C_k = sum over the first k rows of the mean over the merged columns, summed in
// double. Where column c of a cell begins:
//   span.first + (layer (lights + 2) + cell) span.cell_stride + c (R + 1),
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
  std::vector<CumulativeSpan> spans = {};  // [level * views + view]; empty below finest_level
  std::vector<float> sums = {};
};

// finest_level: 0 .. atlas.levels - 1; finer levels are left out. environment false: the
// environment's cells stay zero (their pictures may then be missing in the atlas). Throws
// std::runtime_error when a picture is missing or the sums are more than 2^31.
CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, int finest_level, bool environment);

}  // namespace pluvia
