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
//   span.first + (layer (lights + uniform + 1) + cell) span.cell_stride + c (R + 3),
// cell = index of the light, then the uniform environment where it is there, then coverage.
//
// A streak mixes all harmonics of the sky at once: they lie four by four in arrays of their own,
//   span.first + (layer quads + quad) span.cell_stride + c (R + 3),   span of sky_spans,
// so that four are fetched for one. They may be negative; all share the strip of the first, the
// uniform one, so that any sum of them is a column between the same edges.
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
  std::vector<CumulativeSpan> sky_spans = {};
  std::vector<float> sky_sums = {};  // four a place
};

struct LevelRange {
  int finest = 0, coarsest = 0;  // 0 <= finest <= coarsest < atlas.levels; others are left out
};

constexpr int sky_quads(int sky_cells) {
  return (sky_cells + 3) / 4;
}

// sky_cells: 0 for none, 1 for the uniform environment, else so many of the atlas's harmonics. What
// is not asked for may be missing in the atlas. Throws std::runtime_error when a picture is missing
// or the sums are more than 2^31.
CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, const LevelRange& levels, int sky_cells);

}  // namespace pluvia
