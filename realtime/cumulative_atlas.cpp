#include "realtime/cumulative_atlas.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace pluvia {
namespace {

// Sets the spans and returns how many sums there are.
std::int64_t lay_out(const StreakAtlas& atlas, int finest_level,
                     std::vector<CumulativeSpan>& spans) {
  const auto cells = static_cast<std::int64_t>(atlas.layers.size() * (atlas.lights.size() + 2));
  std::int64_t next = 0;
  for (int level = 0; level < atlas.levels; ++level) {
    const auto begin = spans.size();
    std::int64_t stride = 0;
    for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
      const CellRect cell = cell_rect(atlas, view, 0, 0);
      const int columns = cell.width >> level;
      spans.push_back({static_cast<std::int32_t>(next + stride), cell.height, 0, columns});
      stride += static_cast<std::int64_t>(columns) * (cell.height + 1);
    }
    for (std::size_t i = begin; i < spans.size(); ++i)
      spans[i].cell_stride = static_cast<std::int32_t>(stride);
    if (level < finest_level)
      spans.resize(begin), spans.resize(begin + atlas.views.size());
    else
      next += stride * cells;
    if (next > std::numeric_limits<std::int32_t>::max())
      throw std::runtime_error(fmt::format("atlas: {} sums; expected at most 2^31", next));
  }
  return next;
}

void sum_columns(const Image& picture, const CellRect& cell, int level, float* sums) {
  const int merged = 1 << level;
  for (int x = 0; x < cell.width; x += merged) {
    double sum = 0;
    *sums++ = 0;
    for (int y = 0; y < cell.height; ++y) {
      for (int i = 0; i < merged; ++i) {
        sum += static_cast<double>(picture.at(cell.x + x + i, cell.y + y));
      }
      *sums++ = static_cast<float>(std::ldexp(sum, -level));
    }
  }
}

// The finest picture of a kind.
const Image& picture_of(const AtlasLayer& layer, const std::vector<Image>& levels,
                        const char* kind) {
  if (levels.empty())
    throw std::runtime_error(fmt::format("atlas: oscillation {} has no picture of {}; expected one",
                                         layer.oscillation, kind));
  return levels.front();
}

void sum_layer(const StreakAtlas& atlas, int layer_index, int level, bool environment,
               CumulativeAtlas& result) {
  const AtlasLayer& layer = atlas.layers[static_cast<std::size_t>(layer_index)];
  const int lights = static_cast<int>(atlas.lights.size());
  const int views = static_cast<int>(atlas.views.size());
  for (int view = 0; view < views; ++view) {
    const CumulativeSpan& span = result.spans[static_cast<std::size_t>(level * views + view)];
    for (int cell = 0; cell < lights + 2; ++cell) {
      if (cell == lights && !environment) continue;
      const bool point = cell < lights;
      const Image& picture = point            ? picture_of(layer, layer.point, "point light")
                             : cell == lights ? picture_of(layer, layer.env, "environment")
                                              : picture_of(layer, layer.coverage, "coverage");
      const std::int64_t first =
          span.first + (static_cast<std::int64_t>(layer_index) * (lights + 2) + cell) *
                           static_cast<std::int64_t>(span.cell_stride);
      sum_columns(picture, cell_rect(atlas, view, point ? cell : 0, 0), level,
                  result.sums.data() + first);
    }
  }
}

}  // namespace

CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, int finest_level, bool environment) {
  assert(finest_level >= 0 && finest_level < atlas.levels);
  CumulativeAtlas result;
  const std::int64_t count = lay_out(atlas, finest_level, result.spans);
  result.sums.resize(static_cast<std::size_t>(count));
  const int layers = static_cast<int>(atlas.layers.size());
  tbb::parallel_for(0, layers * (atlas.levels - finest_level), [&](int job) {
    sum_layer(atlas, job % layers, finest_level + job / layers, environment, result);
  });
  return result;
}

}  // namespace pluvia
