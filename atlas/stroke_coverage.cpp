#include "atlas/stroke_coverage.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pluvia {
namespace {

constexpr double least_row = 0.1;  // of the brightest: a fainter one at an end is left off

struct Part {  // of an image
  int x = 0, y = 0, width = 0, height = 0;
};

double at(const Image& image, const Part& part, int x, int y) {
  return static_cast<double>(image.at(part.x + x, part.y + y));
}

// Light of a picture, its width, its middle (from the part's upper left corner) and the line
// through that which is nearest to the light.
struct Middle {
  double light = 0, width = 0;
  double x = 0, y = 0, lean = 0;  // lean: pixels to the right for one down
};

Middle middle_of(const Image& image, const Part& part) {
  double sum = 0, x_sum = 0, y_sum = 0, largest_sum = 0;
  for (int y = 0; y < part.height; ++y) {
    double largest = 0;
    for (int x = 0; x < part.width; ++x) {
      const double value = at(image, part, x, y);
      sum += value, x_sum += value * (x + 0.5), y_sum += value * (y + 0.5);
      largest = std::max(largest, value);
    }
    largest_sum += largest;
  }
  if (sum == 0) return {};
  double xy = 0, yy = 0;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      const double value = at(image, part, x, y), beside = y + 0.5 - y_sum / sum;
      xy += value * beside * (x + 0.5 - x_sum / sum), yy += value * beside * beside;
    }
  }
  return {.light = sum,
          .width = sum / largest_sum,
          .x = x_sum / sum,
          .y = y_sum / sum,
          .lean = yy > 0 ? xy / yy : 0};
}

struct Stroke {
  const StreakStroke& source;
  Middle middle = {};
  int first = 0, rows = 0;  // those that are its length

  const Image& matte() const { return source.matte; }
};

Stroke prepared(const StreakStroke& source) {
  const Image& matte = source.matte;
  const Part all = {0, 0, matte.width, matte.height};
  std::vector<double> light(static_cast<std::size_t>(matte.height), 0.0);
  for (int y = 0; y < matte.height; ++y) {
    for (int x = 0; x < matte.width; ++x)
      light[static_cast<std::size_t>(y)] += at(matte, all, x, y);
  }
  const double least = least_row * *std::max_element(light.begin(), light.end());
  const auto counts = [&](double row) { return row >= least; };
  const auto first = std::find_if(light.begin(), light.end(), counts);
  const auto end = std::find_if(light.rbegin(), light.rend(), counts).base();
  return {.source = source,
          .middle = middle_of(matte, all),
          .first = static_cast<int>(first - light.begin()),
          .rows = static_cast<int>(end - first)};
}

// Integral of max(0, 1 - |x|) up to x.
double tent_before(double x) {
  const double y = std::clamp(x, -1.0, 1.0);
  return y < 0 ? 0.5 * (1 + y) * (1 + y) : 1 - 0.5 * (1 - y) * (1 - y);
}

struct Stretch {
  double low = 0, high = 0;
};

// Mean over a stretch of the values that count .. lie at 0.5, 1.5, ..: linear between, 0 around.
template <typename Value>
double mean_between(const Stretch& stretch, int count, const Value& value) {
  const int first = std::max(0, static_cast<int>(std::floor(stretch.low - 1.5)));
  const int last = std::min(count - 1, static_cast<int>(std::ceil(stretch.high + 0.5)));
  double sum = 0;
  for (int i = first; i <= last; ++i)
    sum += (tent_before(stretch.high - i - 0.5) - tent_before(stretch.low - i - 0.5)) * value(i);
  return sum / (stretch.high - stretch.low);
}

// Where G is not 0.
Part covered_part(const Image& image, const CellRect& cell) {
  int left = cell.width, right = -1, top = cell.height, bottom = -1;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x) {
      if (!(image.at(cell.x + x, cell.y + y) > 0)) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  return {cell.x + left, cell.y + top, right - left + 1, bottom - top + 1};
}

// B, its sum still the stroke's: row after row of the part.
std::vector<double> spread(const Stroke& stroke, const Part& part, const Middle& covered) {
  const Image& matte = stroke.matte();
  const auto width = static_cast<std::size_t>(part.width);
  std::vector<double> across(width * static_cast<std::size_t>(matte.height));
  const double scale = stroke.middle.width / covered.width;
  for (int y = 0; y < matte.height; ++y) {
    const double middle = stroke.middle.x + stroke.middle.lean * (y + 0.5 - stroke.middle.y);
    for (int u = 0; u < part.width; ++u) {
      const double low = middle + scale * (u - covered.x);
      across[width * static_cast<std::size_t>(y) + static_cast<std::size_t>(u)] =
          mean_between({low, low + scale}, matte.width,
                       [&](int x) { return static_cast<double>(matte.at(x, y)); });
    }
  }
  std::vector<double> values;
  const double rows = static_cast<double>(stroke.rows) / part.height;  // of the stroke, for one
  for (int r = 0; r < part.height; ++r) {
    const Stretch down = {stroke.first + rows * r, stroke.first + rows * (r + 1)};
    for (std::size_t u = 0; u < width; ++u)
      values.push_back(mean_between(down, matte.height, [&](int y) {
        return across[width * static_cast<std::size_t>(y) + u];
      }));
  }
  return values;
}

// The least share of G that keeps every texel at most as large as it may be.
double share_of_plain(const std::vector<double>& shaped, const Image& image, const Part& part,
                      double most) {
  double share = 0;
  std::size_t i = 0;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x, ++i) {
      const double plain = at(image, part, x, y), limit = std::max(most, plain);
      if (shaped[i] > limit) share = std::max(share, (shaped[i] - limit) / (shaped[i] - plain));
    }
  }
  return share;
}

// One cell, from the drop's picture into another.
void shape_cell(const Image& plain, const CellRect& cell, const Stroke& stroke, double most,
                Image& shaped) {
  const Part part = covered_part(plain, cell);
  if (part.width <= 0) return;
  const Middle covered = middle_of(plain, part);
  std::vector<double> values = spread(stroke, part, covered);
  double sum = 0;
  for (const double value : values) sum += value;
  if (!(sum > 0))
    throw std::runtime_error(stroke.source.file +
                             ": has no light along its middle; expected a single stroke");
  for (double& value : values) value *= covered.light / sum;
  const double share = share_of_plain(values, plain, part, most);
  std::size_t i = 0;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x, ++i)
      shaped.at(part.x + x, part.y + y) =
          static_cast<float>((1 - share) * values[i] + share * at(plain, part, x, y));
  }
}

Image shaped_picture(const StreakAtlas& atlas, const Image& plain, const Stroke& stroke,
                     double most) {
  Image shaped = make_image(plain.width, plain.height);
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view)
    shape_cell(plain, cell_rect(atlas, view, 0, 0), stroke, most, shaped);
  return shaped;
}

}  // namespace

int shapes_of_set(const StreakAtlas& atlas) {
  const std::size_t sets = atlas.layers.size();
  return static_cast<int>((atlas.strokes.taken.size() + sets - 1) / sets);
}

StreakAtlas stroke_coverage(const StreakAtlas& atlas, double most) {
  StreakAtlas shaped = places_of(atlas);
  std::vector<Stroke> strokes;
  for (const StreakStroke& stroke : atlas.strokes.taken) strokes.push_back(prepared(stroke));
  const int each = shapes_of_set(atlas);
  for (const AtlasLayer& layer : atlas.layers) {
    for (int i = 0; i < each; ++i) {
      const Stroke& stroke = strokes[shaped.layers.size() % strokes.size()];
      shaped.layers.push_back({.oscillation = layer.oscillation});
      shaped.layers.back().coverage = {shaped_picture(atlas, layer.coverage.at(0), stroke, most)};
    }
  }
  return shaped;
}

}  // namespace pluvia
