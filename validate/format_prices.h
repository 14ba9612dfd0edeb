// What the form costs in which pictures of streaks are kept: coarser levels, fewer bits.
#pragma once

#include <vector>

#include "atlas/streak_atlas.h"
#include "validate/price_tags.h"

namespace pluvia {

// Nearest half floats (IEEE 754 binary16, to even): off by at most 2^-11 of the value, or 2^-25
// where that is more. Throws std::runtime_error for a value beyond 65504.
std::vector<float> as_half(const std::vector<float>& picture);

// Steps of largest / 255: off by at most half of one. largest > 0 and not below any value; values
// >= 0. As in the database of 2006, where `largest` is each picture's own factor.
std::vector<float> as_bytes(const std::vector<float>& picture, float largest);

// A cell of one level, row by row.
std::vector<float> cell_of(const StreakAtlas& atlas, const Image& picture, int view, int column,
                           int level);

// Each texel of a level, over the pixels of level 0 that it stands for. fine: the cell at level 0.
std::vector<float> enlarged(const std::vector<float>& coarse, int coarse_width, int level,
                            int fine_width, int fine_height);

// Cells of point lights of one layer that have any light.
int lit_cells(const StreakAtlas& atlas, int layer);

// Over all cells of point lights of one layer: each level against level 0, and, of each level, half
// floats and bytes with a factor for each cell against floats; bytes with one factor for all cells
// besides. A cell without light is left out; with
// fewer than two others there is no price (price_of throws).
std::vector<PriceTag> format_prices(const StreakAtlas& atlas, int layer);

}  // namespace pluvia
