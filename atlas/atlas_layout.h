// Where cells lie: what packing and reading an atlas share.
#pragma once

#include <bit>

#include "atlas/streak_atlas.h"

namespace pluvia {

inline bool is_power_of_two(int value) {
  return value > 0 && std::has_single_bit(static_cast<unsigned>(value));
}

// The first row free below the views, at level 0: the height of a picture, or the row of the next
// view.
inline int rows_of_views(const StreakAtlas& atlas) {
  if (atlas.views.empty()) return 0;
  const int step = 1 << (atlas.levels - 1);
  const AtlasView& last = atlas.views.back();
  return last.row_px + (last.height_px + step - 1) / step * step;
}

}  // namespace pluvia
