// The folders, files and texts in which the rain streak database of Garg and Nayar (2006) lies on
// disk, as programs that open it expect them:
//
//   ROOT/env_light_database/size{4,8,16,32}/cv{0,20,..80}_osc{0..9}.png
//   ROOT/env_light_database/txt/normalized_env_max.txt
//   ROOT/point_light_database/size{4,8,16,32}/dcam{00,20,..80}/cvC_vV_hH_osc{0..9}.png
//   ROOT/point_light_database/txt/dcam{00,20,..80}_point_max.txt
//
// C view elevation, V and H light elevation and azimuth, without leading zeros; V -90, -70 .. 90
// and H 10, 30 .. 170, but at V = +-90 only 170: the 74 of gn2006_light_directions(). 16-bit grey
// PNG, 65535 the maximum; value x factor / 65535 = brightness, factors from the texts. Every row of
// numbers ends in a blank: readers split at blanks and drop the last field.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "atlas/streak_database.h"

namespace pluvia {

inline constexpr std::array<int, 4> gn2006_sizes_px = {32, 16, 8, 4};  // widths, largest first
inline constexpr std::array<int, 5> gn2006_views_deg = {0, 20, 40, 60, 80};
inline constexpr int gn2006_oscillations = 10;

// What a brightness means, S being the streak of a shard (atlas/streak_database.h).
enum class StreakLevel {
  transit,  // S / max(coverage): of the drop while it covers the pixel, as in the files of 2006
  exposure  // S: averaged over the exposure
};

using OscillationFactors = std::array<double, gn2006_oscillations>;  // >= 0, finite

struct ViewFactors {
  int view_elevation_deg = 0;
  OscillationFactors env = {};
  std::vector<OscillationFactors> point = {};  // one for each of gn2006_light_directions()
};

// Paths below ROOT.
std::string gn2006_env_picture(int size_px, int view_elevation_deg, int oscillation);
std::string gn2006_point_picture(int size_px, int view_elevation_deg, const LightDirection& light,
                                 int oscillation);
std::string gn2006_env_factor_file();
std::string gn2006_point_factor_file(int view_elevation_deg);

// Rounded to six significant digits, as many as a 32-bit float surely keeps: the value that the
// texts tell. Finite and >= 0.
double gn2006_told_factor(double factor);

// A view's `cvN` line, then its ten factors; views in the order given.
std::string gn2006_env_factor_text(const std::vector<ViewFactors>& views);

// A line `cvN`, then `vN` lines, each followed by its `hN f0 .. f9 ` lines.
std::string gn2006_point_factor_text(const ViewFactors& view);

// The views that the text holds, ascending, without point factors. Throws std::runtime_error
// "FILE:LINE:COL: found; expected" (`file` is only for that message). Blank lines, carriage returns
// and missing blanks at line ends are no errors.
std::vector<ViewFactors> parse_gn2006_env_factors(const std::string& file, const std::string& text);

// Of all 74 lights. Throws as above.
std::vector<OscillationFactors> parse_gn2006_point_factors(const std::string& file,
                                                           const std::string& text);

}  // namespace pluvia
