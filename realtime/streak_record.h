// What the GPU decides about each visible streak: read back by tests, drawn by rain.vert and
// rain.frag. The layout is that of rain_streaks.glsl (std430).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

namespace pluvia {

struct StreakRecord {  // StreakPlacement of raytrace/streak_placement.h, in float
  glm::vec2 origin_px = {};
  glm::vec2 column_px = {};
  glm::vec2 row_px = {};
  float path_rows = 0;
  float clip_row = 0;  // 1e30 for a whole one
  float depth_m = 0;
  float view_elevation_deg = 0;
  std::int32_t level_layer = 0;  // layer << 8 | level: of environment and coverage; of the atlas
  float counts_for = 1;          // drops (realtime/far_field.h)
  glm::ivec2 view = {};
  glm::vec2 view_weight = {};  // times what the segment counts
};
static_assert(sizeof(StreakRecord) == 64);

inline int level_of(const StreakRecord& record) {
  return record.level_layer & 0xff;
}
inline int layer_of(const StreakRecord& record) {
  return record.level_layer >> 8;
}

struct LitStreakRecord {
  float light[3] = {};     // of a lamp in lux; of a uniform sky in cd/m^2
  std::uint32_t cell = 0;  // layer << 16 | cell of the atlas << 1 | mirrored
};
static_assert(sizeof(LitStreakRecord) == 16);

struct SkyOfStreakRecord {  // SkyOfStreak of rain_sky.glsl
  float cos_turn = 1, sin_turn = 0;
  float transmitted = 1;  // negative: the sky is turned over
  float size = 0;         // index
};
static_assert(sizeof(SkyOfStreakRecord) == 16);

// In order of drop_field and of segments; lit, per streak: for each light one or, with eight taps,
// four, then one for a uniform sky. sky: one a streak where the sky differs by direction.
struct StreakRecords {
  std::size_t lit_per_streak = 0;
  std::vector<StreakRecord> streaks = {};
  std::vector<LitStreakRecord> lit = {};
  std::vector<SkyOfStreakRecord> sky = {};
};

}  // namespace pluvia
