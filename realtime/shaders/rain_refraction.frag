#version 450 core
// Model C (realtime/refraction_look.h): each pixel of a streak is the mean of PERSISTENCE samples of
// the drop on its way through the pixel,
//   (share of the exposure) x mean of (inside the outline) x sum_p weight_p L(direction_p)
// L what the capture shows there, and lamps as discs, met exactly from where the drop is.
//
// Samples are one in each of equal parts of the time in which the drop can cover the pixel, at other
// places in the pixel, and in the next pixel at others again: a lamp's image falls between samples
// here or there, but not all down a streak. An outline that crosses a part counts by its share.
#include "rain_views.glsl"
#include "rain_picture.glsl"
#include "rain_streaks.glsl"
#include "rain_refraction.glsl"

layout(std430, binding = STREAKS) readonly buffer Streaks { Streak streaks[]; };
layout(std430, binding = LIT_STREAKS) readonly buffer LitStreaks { LitStreak lit_streaks[]; };

flat in int streak_index;
layout(location = 0) out vec4 radiance_and_tau;
layout(location = 1) out float weighted_coverage;

struct Sight {  // what all samples of a pixel have in common
  mat3 axes;
  vec3 at_m;    // the drop, from the camera
  int seen, lit_first;
  float side;   // of the patch of the drop that a sample stands for
};

// The lamps that light toward `d` comes from: discs, wider and as much fainter where a sample stands
// for more than a lamp's width. The soft edge, s wide, has the disc's energy times 1 + s^2/(12 C^2).
vec3 lamps_toward(Sight sight, vec3 d, float spread) {
  vec3 sum = vec3(0);
  for (int i = 0; i < counts.y; ++i) {
    LitStreak lamp = lit_streaks[sight.lit_first + 1 + i];
    float cone = uintBitsToFloat(lamp.cell), wide = sqrt(cone * cone + 0.25 * spread * spread);
    float edge = min(spread, wide);
    float away = distance(d, illumination(lights[i], sight.at_m).toward);
    float inside = clamp(0.5 + (wide - away) / max(edge, 1e-6), 0.0, 1.0);
    float share = inside * cone * cone / (wide * wide + edge * edge / 12.0);
    sum += share * vec3(lamp.red, lamp.green, lamp.blue);
  }
  return sum;
}

// rgb: radiance; a: light that is not in the orders kept.
vec4 light_through(Sight sight, float time, vec2 q) {
  vec4 sum = vec4(0, 0, 0, 1);
  for (int order = 0; order < MASK_ORDERS; ++order) {
    vec4 exit = mask_exit(sight.seen, time, order, q);
    vec3 own = normalize(exit.xyz);
    float spread = spread_of(sight.side, impact_of(q), order, length(own.xy));
    vec3 d = sight.axes * own;
    sum += exit.w * vec4(surroundings_toward(d, spread) + lamps_toward(sight, d, spread), -1);
  }
  return sum;
}

// Radii for a step of a column, rows alike; begin and end of the drop's way through the pixel, in
// shares of its path.
struct Passage {
  float radii, begin, end;
};

Passage passage_of(Streak streak, vec2 pixel_place, RainSize size, float reach) {
  Passage passage;
  passage.radii = size.axis_z.w / size.velocity_m_s.w;
  float across = (abs(pixel_place.x - 0.5 * cell.y)) * passage.radii;
  float chord = sqrt(max(reach * reach - across * across, 0.0)) / passage.radii;
  float row = pixel_place.y - cell.x;
  float shown = clamp((streak.clip_row - cell.x) / streak.path_rows, 0.0, 1.0);
  passage.begin = clamp((row - chord) / streak.path_rows, 0.0, shown);
  passage.end = clamp((row + chord) / streak.path_rows, 0.0, shown);
  return passage;
}

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Columns and rows of a place on the screen.
vec2 in_streak(Streak streak, vec2 px) {
  vec2 offset = px - streak.origin_px;
  return vec2(cross2(offset, streak.row_px), cross2(streak.column_px, offset)) /
         cross2(streak.column_px, streak.row_px);
}

Sight sight_of(Streak streak, RainSize size, int size_index, float part) {
  vec2 px = gl_FragCoord.xy - 0.5 * vec2(camera_up.w, camera_forward.w);
  vec3 onward = normalize(camera_right.w * camera_forward.xyz + px.x * camera_right.xyz -
                          px.y * camera_up.xyz);
  Sight sight;
  sight.axes = mask_axes(onward, drop_frame(-onward, size.axis_z.xyz));
  sight.at_m = onward * (streak.depth_m / dot(onward, camera_forward.xyz));
  sight.seen = seen_drop(size_index, layer_of(streak), streak.view_elevation_deg);
  sight.side = part;
  return sight;
}

void main() {
  Streak streak = streaks[streak_index];
  int lit_first = streak_index * (counts.y + 1);
  float transmitted = lit_streaks[lit_first].red;
  int size_index = int(lit_streaks[lit_first].cell);
  RainSize size = rain_sizes[size_index];
  float pixel = size.axis_z.w / size.velocity_m_s.w *
                inversesqrt(abs(cross2(streak.column_px, streak.row_px)));
  Sight sight = sight_of(streak, size, size_index, pixel);
  sight.lit_first = lit_first;
  // A pixel beside the widest outline may still have the drop in its corner.
  float reach = mask_reaches[sight.seen] + pixel;
  vec2 centre = in_streak(streak, gl_FragCoord.xy);
  Passage passage = passage_of(streak, centre, size, reach);
  float lasts = passage.end - passage.begin;
  if (!(lasts > 0.0)) discard;
  float part = lasts * streak.path_rows * passage.radii / float(PERSISTENCE);
  // Patches tile what the pixel sees of the drop, of which a moving one shows a whole chord.
  sight.side = max(sqrt(pixel * part), pixel * inversesqrt(float(PERSISTENCE)));
  // R2 sequence: Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018.
  const vec2 steps = vec2(0.7548776662466927, 0.5698402909980532);
  float turn = PERSISTENCE == 1 ? 0.5 : fract(dot(floor(gl_FragCoord.xy), steps));
  vec4 sum = vec4(0);  // radiance, coverage
  float left_out = 0.0;
  for (int k = 0; k < PERSISTENCE; ++k) {
    float time = passage.begin + (float(k) + turn) / float(PERSISTENCE) * lasts;
    vec2 jitter = fract(0.5 + (float(k) + 37.0 * (turn - 0.5)) * steps) - 0.5;
    vec2 at = in_streak(streak, gl_FragCoord.xy + jitter);
    vec2 place = vec2(at.x - 0.5 * cell.y, cell.x + time * streak.path_rows - at.y) * passage.radii;
    float shown = time * mask_sizes[size_index].y;
    float outline = outline_toward(place, sight.seen, shown), distance_r = length(place);
    // The edge is as soft as the sample is long across it.
    float soft = part * abs(place.y) / max(distance_r, 1e-6) + pixel * inversesqrt(PERSISTENCE);
    float inside = clamp(0.5 + (outline - distance_r) / soft, 0.0, 1.0);
    if (inside == 0.0) continue;
    vec4 light = light_through(sight, shown, place_in_mask(place, outline));
    sum += inside * vec4(light.rgb, 1);
    left_out += inside * light.a;
  }
  sum.rgb += left_out * mean_surroundings();
  sum *= lasts / float(PERSISTENCE) * (streak.view_weight.x + streak.view_weight.y);
  float weight = mean_field_weight(streak.depth_m);
  radiance_and_tau = vec4(weight * transmitted * sum.rgb, optical_depth(sum.a, streak.counts_for));
  weighted_coverage = weight * covered(sum.a, streak.counts_for);
}
