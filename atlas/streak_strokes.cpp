#include "atlas/streak_strokes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/clip_files.h"
#include "atlas/image_io.h"

namespace pluvia {
namespace {

constexpr int most_side_px = 4096;

[[noreturn]] void refuse(const std::string& file, const std::string& found_and_expected) {
  throw std::runtime_error(file + ": " + found_and_expected);
}

void check_stroke(const StreakStroke& stroke) {
  const Image& matte = stroke.matte;
  if (matte.channels != 1)
    refuse(stroke.file, fmt::format("{} channels; expected 1", matte.channels));
  if (std::max(matte.width, matte.height) > most_side_px)
    refuse(stroke.file, fmt::format("{} x {} pixels; expected at most {} x {}", matte.width,
                                    matte.height, most_side_px, most_side_px));
  const auto [least, largest] = std::minmax_element(matte.values.begin(), matte.values.end());
  if (*least < 0) refuse(stroke.file, fmt::format("has a value {}; expected >= 0", *least));
  if (*largest == 0) refuse(stroke.file, "is black; expected a stroke");
}

// Those of most rows, in the order in which they were.
void keep_longest(std::vector<StreakStroke>& strokes) {
  if (strokes.size() <= most_strokes) return;
  const auto rows = [](const StreakStroke& stroke) { return stroke.matte.height; };
  const auto by_rows = [&](const auto& a, const auto& b) { return rows(a) > rows(b); };
  const auto by_name = [](const auto& a, const auto& b) { return a.file < b.file; };
  std::stable_sort(strokes.begin(), strokes.end(), by_rows);
  strokes.resize(most_strokes);
  std::sort(strokes.begin(), strokes.end(), by_name);
}

}  // namespace

StreakStrokes read_streak_strokes(const std::string& folder) {
  StreakStrokes strokes;
  for (const std::string& file : picture_files(folder + "/strokes/*.exr")) {
    strokes.taken.push_back({file, read_image(file)});
    check_stroke(strokes.taken.back());
  }
  strokes.found = strokes.taken.size();
  keep_longest(strokes.taken);
  return strokes;
}

}  // namespace pluvia
