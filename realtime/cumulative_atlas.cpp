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

// Sets the spans of so many cells a layer, and returns how many places they have.
std::int64_t lay_out(const StreakAtlas& atlas, const LevelRange& levels, int cells_per_layer,
                     std::vector<CumulativeSpan>& spans) {
  const auto cells = static_cast<std::int64_t>(atlas.layers.size()) * cells_per_layer;
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

// The sums of one cell, `step` floats apart. strip_cell: the one whose light tells where in a
// column it is.
void sum_columns(const Image& picture, const CellRect& cell, const CellRect& strip_cell, int level,
                 std::ptrdiff_t step, float* sums) {
  const int merged = 1 << level;
  std::vector<double> weights(static_cast<std::size_t>(merged));
  for (int x = 0; x < cell.width; x += merged) {
    double sum = 0;
    std::fill(weights.begin(), weights.end(), 0.0);
    *sums = 0;
    sums += step;
    for (int y = 0; y < cell.height; ++y) {
      for (int i = 0; i < merged; ++i) {
        weights[static_cast<std::size_t>(i)] += picture.at(strip_cell.x + x + i, strip_cell.y + y);
        sum += picture.at(cell.x + x + i, cell.y + y);
      }
      *sums = static_cast<float>(std::ldexp(sum, -level));
      sums += step;
    }
    float strip[2] = {};
    matched_strip(weights, strip);
    *sums = strip[0], sums += step;
    *sums = strip[1], sums += step;
  }
}

std::int64_t place_of(const CumulativeSpan& span, int layer, int cells_per_layer, int cell) {
  return span.first + (static_cast<std::int64_t>(layer) * cells_per_layer + cell) *
                          static_cast<std::int64_t>(span.cell_stride);
}

// One layer and level.
struct Job {
  int layer = 0, level = 0;
};

void sum_layer(const StreakAtlas& atlas, const Job& job, bool uniform, CumulativeAtlas& result) {
  const int cells = cells_per_layer(atlas, uniform);
  const int views = static_cast<int>(atlas.views.size());
  for (int view = 0; view < views; ++view) {
    const CumulativeSpan& span = result.spans[static_cast<std::size_t>(job.level * views + view)];
    for (int i = 0; i < cells; ++i) {
      const AtlasCell cell = finest_cell(atlas, job.layer, i, uniform);
      const CellRect rect = cell_rect(atlas, view, cell.column, 0);
      sum_columns(cell.picture, rect, rect, job.level, 1,
                  result.sums.data() + place_of(span, job.layer, cells, i));
    }
  }
}

void sum_sky(const StreakAtlas& atlas, const Job& job, int harmonics, CumulativeAtlas& result) {
  const int lights = static_cast<int>(atlas.lights.size());
  const Image& picture = finest_cell(atlas, job.layer, lights, harmonics).picture;
  const int views = static_cast<int>(atlas.views.size());
  for (int view = 0; view < views; ++view) {
    const CumulativeSpan& span =
        result.sky_spans[static_cast<std::size_t>(job.level * views + view)];
    for (int i = 0; i < harmonics; ++i)
      sum_columns(picture, cell_rect(atlas, view, i, 0), cell_rect(atlas, view, 0, 0), job.level, 4,
                  result.sky_sums.data() +
                      4 * place_of(span, job.layer, sky_quads(harmonics), i / 4) + i % 4);
  }
}

}  // namespace

CumulativeAtlas cumulative_atlas(const StreakAtlas& atlas, const LevelRange& levels,
                                 int sky_cells) {
  assert(0 <= levels.finest && levels.finest <= levels.coarsest && levels.coarsest < atlas.levels);
  CumulativeAtlas result;
  const bool uniform = sky_cells == 1, harmonics = sky_cells > 1;
  const int cells = cells_per_layer(atlas, uniform);
  result.sums.resize(static_cast<std::size_t>(lay_out(atlas, levels, cells, result.spans)));
  if (harmonics)
    result.sky_sums.resize(4 * static_cast<std::size_t>(
                                   lay_out(atlas, levels, sky_quads(sky_cells), result.sky_spans)));
  const int layers = static_cast<int>(atlas.layers.size());
  tbb::parallel_for(0, layers * (levels.coarsest - levels.finest + 1), [&](int i) {
    const Job job = {.layer = i % layers, .level = levels.finest + i / layers};
    sum_layer(atlas, job, uniform, result);
    if (harmonics) sum_sky(atlas, job, sky_cells, result);
  });
  return result;
}

}  // namespace pluvia
