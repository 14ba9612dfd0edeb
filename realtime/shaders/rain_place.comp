#version 450 core
// One record per visible streak that rain_splat.comp has not drawn, in order of the groups, and one
// per streak and cell that lights it; where it is not traced, one with its radiance.
#include "rain_group.glsl"
#include STREAK_LIGHT
#include "rain_rank.glsl"
#include "rain_streaks.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = GROUP_STARTS) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = STREAKS) writeonly buffer Streaks { Streak streaks[]; };
layout(std430, binding = LIT_STREAKS) writeonly buffer LitStreaks { LitStreak lit_streaks[]; };

#if SKY_CELLS > 1
layout(std430, binding = SKY_STREAKS) writeonly buffer SkyStreaks { SkyOfStreak sky_streaks[]; };
#endif

void keep_lit(uint place, vec3 light, uint cell) {
  lit_streaks[place] = LitStreak(light.r, light.g, light.b, cell);
}

#if REFRACTION
// What reaches the camera and the size; then each lamp as a disc: its radiance, and the chord of its
// half-angle.
void keep_lamps(uint place, Drop drop, Placement placed) {
  RainSize size = rain_sizes[drop.size];
  uint first = place * uint(counts.y + 1);
  float transmitted = exp(-air.x * length(placed.middle_m));
  keep_lit(first, vec3(transmitted), uint(drop.size));
#if LOOK_LIGHTS
  for (int i = 0; i < counts.y; ++i) {
    Illumination lit = illumination(lights[i], placed.middle_m);
    float share = path_lit_share(lights[i], placed.middle_m, size.times.x * velocity_of(drop));
    // Of a lamp with a radius, its own disc.
    bool has_disc = lights[i].place.w != 0.0 && lights[i].intensity.w > 0.0;
    float sine = has_disc ? min(lights[i].intensity.w / lit.distance_m, 1.0) : float(LAMP_SINE);
    float chord = sine * sqrt(2.0 / (1.0 + sqrt(1.0 - sine * sine)));
    vec3 radiance = share / (3.14159265358979 * sine * sine) * lit.lux;
    keep_lit(first + 1u + uint(i), radiance, floatBitsToUint(chord));
  }
#endif
}
#endif

void write_light(uint place, Drop drop, Placement placed) {
#if TRACED
  float transmitted = exp(-air.x * length(placed.middle_m));
  uint first = place * uint(lit_per_streak());
  for (uint i = 0u; i < uint(counts.y); ++i)
    keep_light(first + i * TAPS, lights[i], drop, placed, transmitted);
#if SKY_CELLS == 1
  keep_lit(first + uint(counts.y) * TAPS, transmitted * environment.rgb,
           cell_of(uint(counts.z), false, drop.layer));
#elif SKY_CELLS > 1
  sky_streaks[place] = sky_of(drop, placed.frame, transmitted);
#endif
#elif REFRACTION
  keep_lamps(place, drop, placed);
#else
  keep_lit(place, streak_radiance(drop, placed), 0u);
#endif
}

int choose_level(vec2 column_px, vec2 row_px, float widest_px) {
  float width_px = abs(column_px.x * row_px.y - column_px.y * row_px.x) / length(row_px);
  float level = floor(log2(widest_px / width_px));
  return int(clamp(level, float(sizes.y), float(sizes.z)));
}

void write_streak(uint place, Drop drop, Placement placed) {
  Streak streak;
  streak.origin_px = placed.origin_px;
  streak.column_px = placed.column_px;
  streak.row_px = placed.row_px;
  streak.path_rows = placed.path_rows;
  streak.clip_row = placed.clip_row;
  streak.depth_m = placed.depth_m;
  streak.view_elevation_deg = view_elevation_deg(placed);
  float widest_px = cell.z;
#if LENS
  widest_px = max(widest_px, widest_defocused * circle_px(placed.depth_m));
#endif
  streak.level_layer = drop.layer << 8 | choose_level(placed.column_px, placed.row_px, widest_px);
  streak.counts_for = drop.counts_for;
  streak_views(drop, streak.view_elevation_deg, streak.view, streak.view_weight);
  streaks[place] = streak;
  write_light(place, drop, placed);
}

void main() {
  Drop drop;
  Placement placed;
  bool visible = drop_at(drop_group_index(), place_in_drop_group(), drop) &&
                 place_streak(drop, placed) && in_picture(placed);
  bool wide = visible && !is_thin(placed);
  uint total;
  uint rank = rank_in_group(wide, total);
  if (group_index() * (GROUP_SIZE / DROPS_OF_GROUP) >= uint(sizes.x)) return;
  // Counted by another program, which may have rounded otherwise: never into the next group's room.
  uint first = group_starts[group_index()];
  uint room = group_starts[group_index() + 1u] - first;
  if (wide && rank < room) write_streak(first + rank, drop, placed);
  uint left = total + gl_LocalInvocationID.x;
  if (left < room) streaks[first + left].depth_m = no_streak;
}
