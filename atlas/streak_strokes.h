// Single strokes of rain that were cut out of a clip (`pluvia mattes`, docs/mattes.md), as shapes
// for streaks to take (atlas/stroke_coverage.h). Wang, Lin, Fang, Yang, Yu and Kang,
// MSR-TR-2006-102.
#pragma once

#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

constexpr std::size_t most_strokes = 64;  // of a renderer: each is a layer of its atlas

struct StreakStroke {
  std::string file = {};  // for messages
  Image matte = {};       // one channel, the fall downward, >= 0, not all 0; its scale says nothing
};

struct StreakStrokes {
  std::vector<StreakStroke> taken = {};  // in the order of their names
  std::size_t found = 0;

  bool empty() const { return taken.empty(); }
};

// FOLDER/strokes/*.exr: where there are more than most_strokes, those of most rows, of equals the
// first. Throws std::runtime_error "FILE: what was found; what is expected" for a folder without
// any, and for a picture that has several channels, more than 4096 rows or columns, a value that
// is not finite or below 0, or no light.
StreakStrokes read_streak_strokes(const std::string& folder);

}  // namespace pluvia
