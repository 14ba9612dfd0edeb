// What the placing shader hands to the drawing ones; mirrors StreakRecord and LitStreakRecord of
// realtime/streak_record.h.
struct Streak {
  vec2 origin_px, column_px, row_px;
  float path_rows;
  float clip_row;
  float depth_m;
  float view_elevation_deg;
  int level_layer;    // layer << 8 | level: of environment and coverage; of the atlas, whose texels
  float transmitted;  // are at most cell.z wide on screen. By the fog before it
  ivec2 view;
  vec2 view_weight;
};

struct LitStreak {
  float red_lux, green_lux, blue_lux;
  uint cell;  // layer << 16 | light of the atlas << 1 | mirrored
};

int level_of(Streak streak) { return streak.level_layer & 0xff; }
int layer_of(Streak streak) { return streak.level_layer >> 8; }
