// Strokes as shapes of streaks, made up.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "atlas/streak_strokes.h"

namespace pluvia {

// Five pixels wide, with beads down its length, leaning by so many pixels a row.
inline StreakStroke beaded_stroke(int rows = 24, double lean = 0) {
  StreakStroke stroke = {"beads", make_image(9 + static_cast<int>(std::ceil(lean * rows)), rows)};
  for (int y = 0; y < rows; ++y) {
    const double middle = 4.5 + lean * (y + 0.5), bead = 1.2 + std::sin(0.7 * y);
    for (int x = 0; x < stroke.matte.width; ++x)
      stroke.matte.at(x, y) =
          static_cast<float>(bead * std::exp(-0.5 * std::pow((x + 0.5 - middle) / 1.2, 2)));
  }
  return stroke;
}

// One pixel that is lit.
inline StreakStroke one_pixel() {
  StreakStroke stroke = {"pixel", make_image(1, 1)};
  stroke.matte.values = {0.3f};
  return stroke;
}

// A flash at a quarter of the way: a hundred times as bright as the rest.
inline StreakStroke flashing_stroke() {
  StreakStroke stroke = {"flash", make_image(3, 40)};
  for (float& value : stroke.matte.values) value = 0.01f;
  for (int x = 0; x < 3; ++x) stroke.matte.at(x, 10) = 1;
  return stroke;
}

inline StreakStrokes strokes_of(std::vector<StreakStroke> taken) {
  const std::size_t found = taken.size();
  return {std::move(taken), found};
}

}  // namespace pluvia
