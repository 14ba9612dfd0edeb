// A small atlas with known pictures: a streak with a glint that winds down it, different in every
// cell.
#pragma once

#include <cmath>

#include "atlas/atlas_lookup.h"
#include "atlas/streak_atlas.h"

namespace pluvia {

struct SyntheticSize {
  int cell_width_px = 16;
  int levels = 5;
  int layers = 10;
  double path_rows = 495;  // at view 0
  double margin_rows = 8;  // above and below the path
};

// Smooth, zero at the cell's rim. kind: index of the light, then environment, then coverage.
inline double synthetic_value(int kind, int view, int layer, double u, double r) {
  // u, r in 0..1 across and down the cell
  const double rim = 16 * u * (1 - u) * u * (1 - u) * std::min(1.0, 40 * r * (1 - r));
  const double glint = 0.5 + 0.25 * kind * 0.1 + 0.2 * view + 0.05 * layer;
  const double wind = std::sin(25 * r + 5 * u + 0.7 * kind + 0.3 * layer + 0.2 * view);
  return rim * glint * (1.1 + wind);
}

inline void halve(const StreakAtlas& atlas, std::vector<Image>& levels, int columns) {
  const Image& fine = levels.back();
  const int level = static_cast<int>(levels.size());
  Image coarse = make_image(fine.width / 2, fine.height / 2);
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
    for (int column = 0; column < columns; ++column) {
      const CellRect to = cell_rect(atlas, view, column, level);
      for (int y = to.y; y < to.y + to.height; ++y) {
        for (int x = to.x; x < to.x + to.width; ++x)
          coarse.at(x, y) = (fine.at(2 * x, 2 * y) + fine.at(2 * x + 1, 2 * y) +
                             fine.at(2 * x, 2 * y + 1) + fine.at(2 * x + 1, 2 * y + 1)) /
                            4;
      }
    }
  }
  levels.push_back(std::move(coarse));
}

inline std::vector<Image> synthetic_pictures(const StreakAtlas& atlas, int height, int layer,
                                             int first_kind, int columns, double scale) {
  std::vector<Image> levels = {make_image(columns * atlas.cell_width_px, height)};
  for (int view = 0; view < static_cast<int>(atlas.views.size()); ++view) {
    for (int column = 0; column < columns; ++column) {
      const CellRect cell = cell_rect(atlas, view, column, 0);
      for (int y = 0; y < cell.height; ++y) {
        for (int x = 0; x < cell.width; ++x)
          levels[0].at(cell.x + x, cell.y + y) = static_cast<float>(
              scale * synthetic_value(first_kind + column, view, layer, (x + 0.5) / cell.width,
                                      (y + 0.5) / cell.height));
      }
    }
  }
  while (static_cast<int>(levels.size()) < atlas.levels) halve(atlas, levels, columns);
  return levels;
}

inline StreakAtlas synthetic_atlas(const SyntheticSize& size = {}) {
  StreakAtlas atlas;
  atlas.cell_width_px = size.cell_width_px;
  atlas.levels = size.levels;
  atlas.mean_radius_m = 1.6e-3;
  atlas.exposure_s = 1.0 / 60;
  atlas.fall_speed_m_s = 8.49;
  atlas.pixel_m = atlas.exposure_s * atlas.fall_speed_m_s / size.path_rows;
  atlas.lights = gn2006_light_directions();
  const int step = 1 << (size.levels - 1);
  int row = 0;
  for (const int elevation : {0, 20, 40, 60, 80}) {
    const double path = size.path_rows * std::cos(elevation * 3.14159265358979 / 180);
    const int height = static_cast<int>(std::ceil(path + 2 * size.margin_rows));
    atlas.views.push_back({elevation, height, row, size.margin_rows, size.margin_rows + path});
    row += (height + step - 1) / step * step;
  }
  const int lights = static_cast<int>(atlas.lights.size());
  for (int layer = 0; layer < size.layers; ++layer)
    atlas.layers.push_back({layer, synthetic_pictures(atlas, row, layer, 0, lights, 1),
                            synthetic_pictures(atlas, row, layer, lights, 1, 0.2),
                            synthetic_pictures(atlas, row, layer, lights + 1, 1, 0.01)});
  return atlas;
}

// Adds harmonics: the first as bright as the environment, the others of both signs. A drop's mirror
// image has mirrored pictures, those of odd harmonics (m < 0) with the other sign.
inline void add_harmonics(StreakAtlas& atlas, int degree) {
  const int count = (degree + 1) * (degree + 1), width = atlas.cell_width_px;
  const auto picture = [&](int layer) {
    std::vector<Image> own =
        synthetic_pictures(atlas, atlas.layers[0].env[0].height, layer, 0, 2 * count, 0.05);
    Image sum = make_image(count * width, own[0].height);
    for (int y = 0; y < sum.height; ++y) {
      for (int x = 0; x < sum.width; ++x)
        sum.at(x, y) = own[0].at(x, y) - (x < width ? 0 : own[0].at(count * width + x, y));
    }
    return sum;
  };
  const auto is_odd = [&](int harmonic) {
    int l = 0;
    while ((l + 1) * (l + 1) <= harmonic) ++l;
    return harmonic < l * l + l;
  };
  atlas.transfer_degree = degree;
  for (AtlasLayer& layer : atlas.layers) {
    const Image own = picture(layer.oscillation);
    const Image other = picture(mirrored_oscillation(layer.oscillation));
    layer.transfer = {own};
    for (int y = 0; y < own.height; ++y) {
      for (int x = 0; x < own.width; ++x) {
        const int cell = x / width, flipped = cell * width + width - 1 - x % width;
        const float sign = is_odd(cell) ? -1.0f : 1.0f;
        layer.transfer[0].at(x, y) = own.at(x, y) + sign * other.at(flipped, y);
      }
    }
    while (static_cast<int>(layer.transfer.size()) < atlas.levels)
      halve(atlas, layer.transfer, count);
  }
}

// A quarter of it, for tests that look at places and passes rather than at pictures.
inline const StreakAtlas& quarter_atlas() {
  static const StreakAtlas atlas =
      synthetic_atlas({.cell_width_px = 8, .levels = 4, .path_rows = 247, .margin_rows = 4});
  return atlas;
}

// The numbers of preview.toml, pictures made up.
inline StreakAtlas made_up_atlas(int layers) {
  StreakAtlas atlas = synthetic_atlas(
      {.cell_width_px = 16, .levels = 4, .layers = layers, .path_rows = 247, .margin_rows = 9});
  atlas.exposure_s = 1.0 / 60;
  atlas.fall_speed_m_s = 8.49;
  atlas.pixel_m = 2.0 / 7000;
  atlas.mean_radius_m = 1.6e-3;
  atlas.diameter_um = 3200;
  return atlas;
}

}  // namespace pluvia
