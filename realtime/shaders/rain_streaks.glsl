// What the placing shader hands to the drawing ones; mirrors StreakRecord and LitStreakRecord of
// realtime/streak_record.h.
struct Streak {
  vec2 origin_px, column_px, row_px;
  float path_rows;
  float clip_row;
  float depth_m;      // or no_streak
  float view_elevation_deg;
  int level_layer;    // layer << 8 | level: of environment and coverage; of the atlas, whose texels
  float counts_for;   // are at most cell.z wide on screen. Drops (realtime/far_field.h)
  ivec2 view;
  vec2 view_weight;
};
const float no_streak = 0.0;

// One cell that lights a streak: of a light, in lux, or of the uniform sky, in cd/m^2. Of a streak
// that is not traced, its radiance in cd/m^2; of one that refracts, first the share that reaches the
// camera and the size of its drop, then each lamp's radiance and the chord of its half-angle.
struct LitStreak {
  float red, green, blue;
  uint cell;  // layer << 16 | cell of the atlas << 1 | mirrored
};

// Per streak: TAPS for each light of the scene, then one for a uniform sky. A sky of more cells has
// its harmonics beside them (rain_sky.glsl).
const int uniform_sky = SKY_CELLS == 1 ? 1 : 0;
#if TRACED
int lit_per_streak() { return counts.y * TAPS + uniform_sky; }
#endif

// Cells of an atlas layer among the sums: its lights, the uniform sky's, coverage last.
int cells_per_layer() { return counts.z + uniform_sky + 1; }

int level_of(Streak streak) { return streak.level_layer & 0xff; }
int layer_of(Streak streak) { return streak.level_layer >> 8; }
