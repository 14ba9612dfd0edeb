// How a traced streak is lit: for each light of the scene, cells of the atlas with weights in lux, by
// the rule of atlas/atlas_lookup.h.
#include "rain_shade.glsl"
#include "rain_views.glsl"

layout(std430, binding = ATLAS_LAYERS) readonly buffer AtlasLayers { int mirrored_layer[]; };

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

// Where the shader that includes this keeps what a light adds to a streak: TAPS places for each.
void keep_lit(uint place, vec3 lux, uint cell);

#if TAPS == 1
layout(std430, binding = ATLAS_LIGHTS) readonly buffer AtlasLights { vec4 atlas_lights[]; };
layout(std430, binding = LIGHT_CANDIDATES) readonly buffer LightCandidates {
  uint light_candidates[];
};

// Cell of the square that an octahedron unfolds to (realtime/light_candidates.h).
uint candidates_cell(vec3 d) {
  vec2 square = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
  if (d.z < 0.0)
    square = (1.0 - abs(square.yx)) * mix(vec2(-1), vec2(1), greaterThanEqual(square, vec2(0)));
  const float cells = float(CANDIDATE_CELLS);
  uvec2 cell = uvec2(clamp(0.5 * (square + 1.0) * cells, 0.0, cells - 0.5));
  return cell.y * CANDIDATE_CELLS + cell.x;
}

// The light of the atlas nearest to a folded direction; ties: the lower index. A tie is what lies
// within the rounding of float: 1e-6 of squared chord is 0.0003 degrees at 10 degrees.
uint nearest_light(vec3 wanted) {
  uint cell = candidates_cell(wanted), nearest = 0u;
  float least = 5.0;  // a squared chord is at most 4
  for (uint i = light_candidates[cell]; i < light_candidates[cell + 1u]; ++i) {
    vec3 chord = wanted - atlas_lights[light_candidates[i]].xyz;
    float squared = dot(chord, chord);
    if (squared < least - 1e-6) {
      least = squared;
      nearest = light_candidates[i];
    }
  }
  return nearest;
}

void keep_taps(uint first, vec3 lux, Folded folded, int layer) {
  keep_lit(first, lux, cell_of(nearest_light(folded.direction), folded.mirrored, layer));
}
#else
layout(std430, binding = LIGHT_ROWS) readonly buffer LightRows { vec4 light_rows[]; };
layout(std430, binding = LIGHT_ENTRIES) readonly buffer LightEntries { vec4 light_entries[]; };

// tap_row of atlas/atlas_lookup.cpp.
void keep_row(uint first, vec4 row, float azimuth_deg, vec3 lux, bool mirrored, int layer) {
  int begin = int(row.y), count = int(row.z), above = 0;
  while (above < count && light_entries[begin + above].x <= azimuth_deg) ++above;
  vec4 low = light_entries[begin + (above + count - 1) % count];
  vec4 high = light_entries[begin + above % count];
  float from = low.x - (above == 0 ? 360.0 : 0.0), to = high.x + (above == count ? 360.0 : 0.0);
  float share = count > 1 ? (azimuth_deg - from) / (to - from) : 0.0;
  vec3 a = (1.0 - share) * lux, b = share * lux;
  keep_lit(first, a, cell_of(uint(low.y), mirrored != (low.z != 0.0), layer));
  keep_lit(first + 1u, b, cell_of(uint(high.y), mirrored != (high.z != 0.0), layer));
}

void keep_taps(uint first, vec3 lux, Folded folded, int layer) {
  vec3 d = folded.direction;
  float elevation_deg = degrees_per_radian * atan(d.z, length(d.xy));
  float azimuth_deg = length(d.xy) > 0.0 ? degrees_per_radian * atan(d.y, d.x) : 0.0;
  int above = 0, rows = light_rows.length();
  while (above < rows && light_rows[above].x <= elevation_deg) ++above;
  vec4 low = light_rows[max(above - 1, 0)], high = light_rows[min(above, rows - 1)];
  float share = high.x > low.x ? (elevation_deg - low.x) / (high.x - low.x) : 0.0;
  keep_row(first, low, azimuth_deg, (1.0 - share) * lux, folded.mirrored, layer);
  keep_row(first + 2u, high, azimuth_deg, share * lux, folded.mirrored, layer);
}
#endif

#if SKY_CELLS > 1
#include "rain_sky.glsl"

SkyOfStreak sky_of(Drop drop, DropFrame frame, float transmitted) {
  RainSize size = rain_sizes[drop.size];
  vec2 turn = vec2(dot(frame.x, size.axis_x.xyz), dot(frame.x, size.axis_y.xyz));
#if MOTION
  // About the size's fall in still air, whichever way the drop goes; level it may go that way.
  turn = length(turn) > 1e-6 ? normalize(turn) : vec2(1, 0);
#else
  turn = normalize(turn);
#endif
  bool over = flips_views_below() && frame.sin_view < 0.0;
  return SkyOfStreak(turn.x, turn.y, over ? -transmitted : transmitted, float(drop.size));
}
#endif

// What one light adds, kept from place `first` on. transmitted: by the fog before the streak.
void keep_light(uint first, Light light, Drop drop, Placement placed, float transmitted) {
  RainSize size = rain_sizes[drop.size];
  Illumination lit = illumination(light, placed.middle_m);
  vec3 path_m = size.times.x * velocity_of(drop);
  vec3 lux = transmitted * path_lit_share(light, placed.middle_m, path_m) * lit.lux;
  keep_taps(first, lux, fold(lit.toward, placed.frame), drop.layer);
}
