#include "validate/format_prices.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Imath/half.h>
#include <fmt/format.h>

namespace pluvia {
namespace {

using Picture = std::vector<float>;

float largest_of(const Picture& picture) {
  return *std::max_element(picture.begin(), picture.end());
}

struct LevelSums {
  std::vector<StreakSums> coarse = {}, half = {}, bytes = {}, shared = {};
};

void add_cell(const StreakAtlas& atlas, const AtlasLayer& layer, int view, int column, int level,
              float largest, LevelSums& sums) {
  const Picture finest = cell_of(atlas, layer.point[0], view, column, 0);
  if (largest_of(finest) <= 0) return;
  const Picture picture =
      cell_of(atlas, layer.point[static_cast<std::size_t>(level)], view, column, level);
  const CellRect fine = cell_rect(atlas, view, column, 0);
  const int width = cell_rect(atlas, view, column, level).width;
  sums.coarse.push_back(
      streak_sums(enlarged(picture, width, level, fine.width, fine.height), finest));
  sums.half.push_back(streak_sums(as_half(picture), picture));
  sums.bytes.push_back(streak_sums(as_bytes(picture, largest_of(picture)), picture));
  sums.shared.push_back(streak_sums(as_bytes(picture, largest), picture));
}

LevelSums level_sums(const StreakAtlas& atlas, const AtlasLayer& layer, int level) {
  const auto& values = layer.point[static_cast<std::size_t>(level)].values;
  const float largest = *std::max_element(values.begin(), values.end());
  LevelSums sums;
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
    for (int column = 0; column < static_cast<int>(atlas.lights.size()); ++column)
      add_cell(atlas, layer, view, column, level, largest, sums);
  }
  return sums;
}

}  // namespace

std::vector<float> as_half(const std::vector<float>& picture) {
  std::vector<float> rounded;
  for (const float value : picture) {
    if (!(std::abs(value) <= 65504))
      throw std::runtime_error(fmt::format("half float of {}; expected at most 65504", value));
    rounded.push_back(half(value));
  }
  return rounded;
}

std::vector<float> as_bytes(const std::vector<float>& picture, float largest) {
  if (!(largest > 0))
    throw std::runtime_error(fmt::format("bytes up to {}; expected > 0", largest));
  std::vector<float> rounded;
  for (const float value : picture) {
    if (!(value >= 0 && value <= largest))
      throw std::runtime_error(fmt::format("byte of {}; expected 0 .. {}", value, largest));
    rounded.push_back(std::round(255 * value / largest) * largest / 255);
  }
  return rounded;
}

std::vector<float> cell_of(const StreakAtlas& atlas, const Image& picture, int view, int column,
                           int level) {
  const CellRect cell = cell_rect(atlas, view, column, level);
  std::vector<float> values;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x) values.push_back(picture.at(cell.x + x, cell.y + y));
  }
  return values;
}

std::vector<float> enlarged(const std::vector<float>& coarse, int coarse_width, int level,
                            int fine_width, int fine_height) {
  std::vector<float> fine;
  for (int y = 0; y < fine_height; ++y) {
    for (int x = 0; x < fine_width; ++x)
      fine.push_back(
          coarse.at(static_cast<std::size_t>((y >> level) * coarse_width + (x >> level))));
  }
  return fine;
}

int lit_cells(const StreakAtlas& atlas, int layer) {
  const Image& picture = atlas.layers.at(static_cast<std::size_t>(layer)).point.at(0);
  int lit = 0;
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
    for (int column = 0; column < static_cast<int>(atlas.lights.size()); ++column)
      lit += largest_of(cell_of(atlas, picture, view, column, 0)) > 0 ? 1 : 0;
  }
  return lit;
}

std::vector<PriceTag> format_prices(const StreakAtlas& atlas, int layer) {
  const AtlasLayer& pictures = atlas.layers.at(static_cast<std::size_t>(layer));
  std::vector<PriceTag> tags;
  for (int level = 0; level < atlas.levels; ++level) {
    const LevelSums sums = level_sums(atlas, pictures, level);
    const int width = atlas.cell_width_px >> level;
    const auto add = [&](const std::string& what, const std::string& against,
                         const std::vector<StreakSums>& of, const std::string& cost) {
      tags.push_back({fmt::format("{} across: {}",
                                  width == 1 ? "1 texel" : fmt::format("{} texels", width), what),
                      against, price_of(of), cost});
    };
    const std::string share = fmt::format("1 / {} of the texels", 1 << (2 * level));
    if (level > 0) add("floats", "the finest level", sums.coarse, share);
    add("half floats", "floats", sums.half, "half the bytes");
    add("8 bits, a factor for each cell", "floats", sums.bytes, "a quarter of the bytes");
    if (level == 0)
      add("8 bits, one factor for all cells", "floats", sums.shared, "a quarter of the bytes");
  }
  return tags;
}

}  // namespace pluvia
