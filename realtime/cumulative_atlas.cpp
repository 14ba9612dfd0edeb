#include "realtime/cumulative_atlas.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace pluvia {
namespace {

// Sets the spans and returns how many sums there are.
std::int64_t lay_out(const StreakAtlas& atlas, const LevelRange& levels,
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
      stride += static_cast<std::int64_t>(columns) * (cell.height + 3);
    }
    for (std::size_t i = begin; i < spans.size(); ++i)
      spans[i].cell_stride = static_cast<std::int32_t>(stride);
    if (level < levels.finest || level > levels.coarsest)
      spans.resize(begin), spans.resize(begin + atlas.views.size());
    else
      next += stride * cells;
    if (next > std::numeric_limits<std::int32_t>::max())
      throw std::runtime_error(fmt::format("atlas: {} sums; expected at most 2^31", next));
  }
  return next;
}

// Centre and half width of the uniform strip with the mean and variance of weights on equal parts
// of [0, 1]. The whole of [0, 1] where there is no weight; kept inside it where the weight is at
// both ends.
void matched_strip(const std::vector<double>& weights, float* strip) {
  const double width = 1.0 / static_cast<double>(weights.size());
  double total = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double x = (static_cast<double>(i) + 0.5) * width;
    total += weights[i];
    mean += weights[i] * x;
    square += weights[i] * (x * x + width * width / 12);
  }
  strip[0] = strip[1] = 0.5f;
  if (!(total > 0)) return;
  mean /= total;
  const double half = std::sqrt(3 * std::max(0.0, square / total - mean * mean));
  strip[0] = static_cast<float>(mean);
  strip[1] = static_cast<float>(std::min({half, mean, 1 - mean}));
}

void sum_columns(const Image& picture, const CellRect& cell, int level, float* sums) {
  const int merged = 1 << level;
  std::vector<double> weights(static_cast<std::size_t>(merged));
  for (int x = 0; x < cell.width; x += merged) {
    double sum = 0;
    std::fill(weights.begin(), weights.end(), 0.0);
    *sums++ = 0;
    for (int y = 0; y < cell.height; ++y) {
      for (int i = 0; i < merged; ++i) {
        const double value = picture.at(cell.x + x + i, cell.y + y);
        weights[static_cast<std::size_t>(i)] += value;
        sum += value;
      }
      *sums++ = static_cast<float>(std::ldexp(sum, -level));
    }
    matched_strip(weights, sums);
    sums += 2;
  }
}

void sum_layer(const StreakAtlas& atlas, int layer_index, int level, bool environment,
               CumulativeAtlas& result) {
  const int lights = static_cast<int>(atlas.lights.size());
  const int views = static_cast<int>(atlas.views.size());
  for (int view = 0; view < views; ++view) {
    const CumulativeSpan& span = result.spans[static_cast<std::size_t>(level * views + view)];
    for (int cell = 0; cell < lights + 2; ++cell) {
      if (cell == lights && !environment) continue;
      const std::int64_t first =
          span.first + (static_cast<std::int64_t>(layer_index) * (lights + 2) + cell) *
                           static_cast<std::int64_t>(span.cell_stride);
      sum_columns(finest_picture(atlas, layer_index, cell),
                  cell_rect(atlas, view, cell < lights ? cell : 0, 0), level,
                  result.sums.data() + first);
    }
  }
}

}  // namespace

CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, const LevelRange& levels,
                                 bool environment) {
  assert(0 <= levels.finest && levels.finest <= levels.coarsest && levels.coarsest < atlas.levels);
  CumulativeAtlas result;
  const std::int64_t count = lay_out(atlas, levels, result.spans);
  result.sums.resize(static_cast<std::size_t>(count));
  const int layers = static_cast<int>(atlas.layers.size());
  tbb::parallel_for(0, layers * (levels.coarsest - levels.finest + 1), [&](int job) {
    sum_layer(atlas, job % layers, levels.finest + job / layers, environment, result);
  });
  return result;
}

}  // namespace pluvia
