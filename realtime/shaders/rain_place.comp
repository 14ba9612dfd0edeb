#version 450 core
// One record per visible streak, in order of the groups, and one per streak and light.
#include "rain_group.glsl"
#include "rain_placement.glsl"
#include "rain_rank.glsl"
#include "rain_streaks.glsl"
#include "shadows.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = GROUP_STARTS) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = STREAKS) writeonly buffer Streaks { Streak streaks[]; };
layout(std430, binding = LIT_STREAKS) writeonly buffer LitStreaks { LitStreak lit_streaks[]; };

layout(std430, binding = ATLAS_LIGHTS) readonly buffer AtlasLights { vec4 atlas_lights[]; };
layout(std430, binding = ATLAS_LAYERS) readonly buffer AtlasLayers { int mirrored_layer[]; };
layout(std430, binding = ATLAS_VIEWS) readonly buffer AtlasViews { vec4 atlas_views[]; };  // x: deg

const float degrees_per_radian = 57.29577951308232;

// The light of the atlas nearest to a folded direction; ties: the lower index. A tie is what lies
// within the rounding of float: 1e-6 of squared chord is 0.0003 degrees at 10 degrees.
uint nearest_light(vec3 wanted) {
  uint nearest = 0u;
  float least = 5.0;  // a squared chord is at most 4
  for (int i = 0; i < counts.z; ++i) {
    vec3 chord = wanted - atlas_lights[i].xyz;
    float squared = dot(chord, chord);
    if (squared < least - 1e-6) {
      least = squared;
      nearest = uint(i);
    }
  }
  return nearest;
}

// Views from below, where the atlas has none of its own, are served by those from above.
bool flips_views_below() {
  return atlas_views[0].x >= 0.0;
}

// A direction in the drop's frame as the database files it (fold_angles of atlas/atlas_lookup.h):
// azimuth below 0 is the mirrored drop's; where a view from below is served by one from above, the
// light's elevation turns over.
struct Folded {
  vec3 direction;
  bool mirrored;
};

Folded fold(vec3 toward, DropFrame frame) {
  vec3 folded = vec3(dot(toward, frame.x), dot(toward, frame.y), dot(toward, frame.z));
  if (flips_views_below() && frame.sin_view < 0.0) folded.z = -folded.z;
  bool mirrored = folded.y < 0.0;
  folded.y = abs(folded.y);
  return Folded(folded, mirrored);
}

uint cell_of(uint light, bool mirrored, int layer) {
  uint set = uint(mirrored ? mirrored_layer[layer] : layer);
  return set << 16 | light << 1 | (mirrored ? 1u : 0u);
}

#if TAPS == 1
void write_lit(uint first, vec3 lux, Folded folded, int layer) {
  lit_streaks[first] =
      LitStreak(lux.r, lux.g, lux.b,
                cell_of(nearest_light(folded.direction), folded.mirrored, layer));
}
#else
layout(std430, binding = LIGHT_ROWS) readonly buffer LightRows { vec4 light_rows[]; };
layout(std430, binding = LIGHT_ENTRIES) readonly buffer LightEntries { vec4 light_entries[]; };

// tap_row of atlas/atlas_lookup.cpp.
void write_row(uint first, vec4 row, float azimuth_deg, vec3 lux, bool mirrored, int layer) {
  int begin = int(row.y), count = int(row.z), above = 0;
  while (above < count && light_entries[begin + above].x <= azimuth_deg) ++above;
  vec4 low = light_entries[begin + (above + count - 1) % count];
  vec4 high = light_entries[begin + above % count];
  float from = low.x - (above == 0 ? 360.0 : 0.0), to = high.x + (above == count ? 360.0 : 0.0);
  float share = count > 1 ? (azimuth_deg - from) / (to - from) : 0.0;
  vec3 a = (1.0 - share) * lux, b = share * lux;
  lit_streaks[first] =
      LitStreak(a.r, a.g, a.b, cell_of(uint(low.y), mirrored != (low.z != 0.0), layer));
  lit_streaks[first + 1u] =
      LitStreak(b.r, b.g, b.b, cell_of(uint(high.y), mirrored != (high.z != 0.0), layer));
}

void write_lit(uint first, vec3 lux, Folded folded, int layer) {
  vec3 d = folded.direction;
  float elevation_deg = degrees_per_radian * atan(d.z, length(d.xy));
  float azimuth_deg = length(d.xy) > 0.0 ? degrees_per_radian * atan(d.y, d.x) : 0.0;
  int above = 0, rows = light_rows.length();
  while (above < rows && light_rows[above].x <= elevation_deg) ++above;
  vec4 low = light_rows[max(above - 1, 0)], high = light_rows[min(above, rows - 1)];
  float share = high.x > low.x ? (elevation_deg - low.x) / (high.x - low.x) : 0.0;
  write_row(first, low, azimuth_deg, (1.0 - share) * lux, folded.mirrored, layer);
  write_row(first + 2u, high, azimuth_deg, share * lux, folded.mirrored, layer);
}
#endif

void choose_views(float elevation_deg, out ivec2 view, out vec2 weight) {
  int above = 0;
  while (above < counts.w && atlas_views[above].x <= elevation_deg) ++above;
  view = ivec2(clamp(above - 1, 0, counts.w - 1), clamp(above, 0, counts.w - 1));
  weight = vec2(1, 0);
  if (above == 0 || above == counts.w) return;
  float low = atlas_views[view.x].x, high = atlas_views[view.y].x;
  weight.y = (elevation_deg - low) / (high - low);
#if VIEW_TAPS == 1
  weight.y = weight.y > 0.5 ? 1.0 : 0.0;
  if (weight.y == 1.0) view.x = view.y;
  weight = vec2(1, 0);
#else
  weight.x = 1.0 - weight.y;
#endif
}

int choose_level(vec2 column_px, vec2 row_px) {
  float width_px = abs(column_px.x * row_px.y - column_px.y * row_px.x) / length(row_px);
  float level = floor(log2(cell.z / width_px));
  return int(clamp(level, float(sizes.y), float(sizes.z)));
}

// The mean over the path, at the middles of its quarters.
float path_lit_share(Light light, vec3 middle_m, vec3 path_m) {
  if (light.more.y < 0.0) return 1.0;
  float sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    vec3 at_m = middle_m + (float(k) - 1.5) / 4.0 * path_m;
    Illumination lit = illumination(light, at_m);
    // Two texels toward the light: a surface that the drop is about to hit does not shade it.
    float texel_m = light.more.w * (light.place.w == 0.0 ? 1.0 : lit.distance_m);
    sum += lit_share(light, at_m + camera_m.xyz + 2.0 * texel_m * lit.toward, lit.toward);
  }
  return sum / 4.0;
}

void write_streak(uint place, Drop drop, Placement placed) {
  Streak streak;
  streak.origin_px = placed.origin_px;
  streak.column_px = placed.column_px;
  streak.row_px = placed.row_px;
  streak.path_rows = placed.path_rows;
  streak.clip_row = placed.clip_row;
  streak.depth_m = placed.depth_m;
  // atan: a driver's asin may err by 5e-4.
  streak.view_elevation_deg =
      degrees_per_radian * atan(placed.frame.sin_view, placed.frame.cos_view);
  streak.level_layer = drop.layer << 8 | choose_level(placed.column_px, placed.row_px);
  streak.transmitted = exp(-air.x * length(placed.middle_m));
  float view_deg = streak.view_elevation_deg;
  choose_views(flips_views_below() ? abs(view_deg) : view_deg, streak.view, streak.view_weight);
  // What the picture's values count is part of their weight.
  streak.view_weight *= rain_sizes[drop.size].times.z;
  streaks[place] = streak;
  vec3 path_m = rain_sizes[drop.size].times.x * rain_sizes[drop.size].velocity_m_s.xyz;
  for (uint i = 0u; i < uint(counts.y); ++i) {
    Illumination lit = illumination(lights[i], placed.middle_m);
    lit.lux *= streak.transmitted * path_lit_share(lights[i], placed.middle_m, path_m);
    write_lit((place * uint(counts.y) + i) * TAPS, lit.lux, fold(lit.toward, placed.frame),
              drop.layer);
  }
}

void main() {
  Drop drop;
  Placement placed;
  bool visible = drop_at(group_index(), gl_LocalInvocationID.x, drop) &&
                 place_streak(drop, placed) && in_picture(placed);
  uint total;
  uint rank = rank_in_group(visible, total);
  if (visible) write_streak(group_starts[group_index()] + rank, drop, placed);
}
