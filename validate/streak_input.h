// Streaks to fit, from a shard of a database or from a picture.
#pragma once

#include <string>
#include <vector>

#include "validate/streak_fit.h"

namespace pluvia {

struct StreakInput {
  std::vector<MeasuredStreak> streaks = {};
  int view_elevation_deg = 0;
  int width_px = 0, height_px = 0;
  bool known_level = true;  // false: a picture's values are in a unit of their own
};

// "light_v+10_h050" (atlas/streak_database.h). Throws std::runtime_error for anything else.
LightDirection parse_light_name(const std::string& name);

// .exr: the lights of those names in the shard (all of them when none is named); the view is the
// shard's own. Any other image that OpenImageIO reads: one channel of linear values, lit by the one
// light named, seen from view_elevation_deg. Throws std::runtime_error "FILE: found; expected".
StreakInput read_streaks(const std::string& file, const std::vector<std::string>& lights,
                         int view_elevation_deg);

}  // namespace pluvia
