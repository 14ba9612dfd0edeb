#include "realtime/streak_profiles.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace pluvia {
namespace {

// Light of the rows so far, of the two halves of a cell.
struct HalfSums {
  std::array<double, 2> flux = {}, moment = {}, square = {};  // square: in cell widths, squared
};

std::int64_t lay_out(const StreakAtlas& atlas, int sky_cells, StreakProfiles& profiles) {
  const auto cells =
      static_cast<std::int64_t>(atlas.layers.size()) * cells_per_layer(atlas, sky_cells);
  std::int64_t next = 0;
  int longest = 0;
  do {
    const int rows_per_bin = 1 << (profiles.first + profiles.levels++);
    longest = 0;
    for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
      const int rows = cell_rect(atlas, view, 0, 0).height;
      const int bins = (rows + rows_per_bin - 1) / rows_per_bin;
      profiles.spans.push_back({static_cast<std::int32_t>(next), bins, 2 * (bins + 1), rows});
      next += cells * (2 * (bins + 1));
      longest = std::max(longest, bins);
    }
    if (next > std::numeric_limits<std::int32_t>::max())
      throw std::runtime_error(
          fmt::format("atlas: profiles of {} values; expected at most 2^31", next));
  } while (longest > 2);
  return next;
}

void add_row(const Image& picture, const CellRect& cell, int y, HalfSums& sums) {
  const double texel = 1.0 / cell.width;
  for (int x = 0; x < cell.width; ++x) {
    // A cell of one column lies half in each half.
    const double centre = (x + 0.5) * texel - 0.5;
    const double value = static_cast<double>(picture.at(cell.x + x, cell.y + y)) * texel;
    const bool straddles = centre == 0;
    for (const int half : {0, 1}) {
      if (!straddles && (centre > 0) != (half == 1)) continue;
      const double place = straddles ? (half == 1 ? 0.25 : -0.25) * texel : centre;
      const double share = straddles ? 0.5 * value : value;
      const double wide = straddles ? 0.5 * texel : texel;
      const auto i = static_cast<std::size_t>(half);
      sums.flux[i] += share;
      sums.moment[i] += share * place;
      sums.square[i] += share * (place * place + wide * wide / 12);
    }
  }
}

void sum_cell(const Image& picture, const CellRect& cell, const ProfileSpan& span, int rows_per_bin,
              float* values) {
  HalfSums sums;
  const auto put = [&](int edge) {
    float* at = values + 8 * edge;
    const auto write = [&](const std::array<double, 2>& halves, int i) {
      at[i] = static_cast<float>(halves[0] + halves[1]);
      at[4 + i] = static_cast<float>(halves[0]);
    };
    write(sums.flux, 0);
    write(sums.moment, 1);
    write(sums.square, 2);
  };
  put(0);
  for (int y = 0; y < cell.height; ++y) {
    add_row(picture, cell, y, sums);
    if ((y + 1) % rows_per_bin == 0) put((y + 1) / rows_per_bin);
  }
  put(span.bins);
}

void sum_layer(const StreakAtlas& atlas, int layer_index, int level, int sky_cells,
               StreakProfiles& profiles) {
  const int cells = cells_per_layer(atlas, sky_cells);
  const int views = static_cast<int>(atlas.views.size());
  for (int view = 0; view < views; ++view) {
    const ProfileSpan& span = profiles.spans[static_cast<std::size_t>(level * views + view)];
    for (int i = 0; i < cells; ++i) {
      const std::int64_t first = span.first + (static_cast<std::int64_t>(layer_index) * cells + i) *
                                                  static_cast<std::int64_t>(span.cell_stride);
      const AtlasCell cell = finest_cell(atlas, layer_index, i, sky_cells);
      sum_cell(cell.picture, cell_rect(atlas, view, cell.column, 0), span,
               1 << (profiles.first + level), profiles.values.data() + 4 * first);
    }
  }
}

}  // namespace

StreakProfiles streak_profiles(const StreakAtlas& atlas, int first, int sky_cells) {
  assert(first >= 0);
  StreakProfiles profiles = {.first = first};
  const std::int64_t count = lay_out(atlas, sky_cells, profiles);
  profiles.values.resize(4 * static_cast<std::size_t>(count));
  const int layers = static_cast<int>(atlas.layers.size());
  tbb::parallel_for(0, layers * profiles.levels, [&](int job) {
    sum_layer(atlas, job % layers, job / layers, sky_cells, profiles);
  });
  return profiles;
}

}  // namespace pluvia
