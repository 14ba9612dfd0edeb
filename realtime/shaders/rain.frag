#version 450 core
// C = (1 - coverage) B + sum_lights E_l S_l + sum_sky c_k S_k: here the sums and coverage, averaged
// over the pixel.
//
// A streak is a row of slanted strips, one per texel column, narrowed to where the column's light is
// (realtime/cumulative_atlas.h). Each adds
//   (area of strip and pixel) x (mean of the column between the rows where its centre line crosses)
// and the mean is the difference of two cumulative sums: exact for any stretch of the rows, and no
// tap ever leaves its cell.
#include "rain_picture.glsl"
#include "rain_streaks.glsl"
#if LENS
#include "rain_lens.glsl"
#endif

layout(std430, binding = STREAKS) readonly buffer Streaks { Streak streaks[]; };
layout(std430, binding = LIT_STREAKS) readonly buffer LitStreaks { LitStreak lit_streaks[]; };
layout(std430, binding = ATLAS_VIEWS) readonly buffer AtlasViews { vec4 atlas_views[]; };
layout(std430, binding = ATLAS_SPANS) readonly buffer AtlasSpans { ivec4 atlas_spans[]; };
layout(binding = CUMULATIVE) uniform sampler2DArray cumulative_sums;
#if SKY_CELLS > 1
#include "rain_sky.glsl"
layout(std430, binding = SKY_STREAKS) readonly buffer SkyStreaks { SkyOfStreak sky_streaks[]; };
layout(std430, binding = SKY_SPANS) readonly buffer SkySpans { ivec4 sky_spans[]; };
layout(binding = SKY_SUMS) uniform sampler2DArray sky_sums;
#endif

flat in int streak_index;
layout(location = 0) out vec4 radiance_and_tau;
layout(location = 1) out float weighted_coverage;

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Area of the unit square on the near side of a line at signed distance d from its centre, with
// normal n = (a, b), a >= b >= 0, a^2 + b^2 = 1.
float half_plane_area(float d, float a, float b) {
  float reach = 0.5 * (a + b), flat_reach = 0.5 * (a - b);
  if (abs(d) <= flat_reach) return 0.5 + d / a;
  float rest = max(reach - abs(d), 0.0);
  float corner = rest * rest / max(2.0 * a * b, 1e-20);
  return d > 0.0 ? 1.0 - corner : corner;
}

ivec3 place_of_sum(int i) {
  return ivec3(i & SUMS_WIDTH - 1, i / SUMS_WIDTH & SUMS_HEIGHT - 1,
               i / (SUMS_WIDTH * SUMS_HEIGHT));
}

float cumulative(int i) {
  return texelFetch(cumulative_sums, place_of_sum(i), 0).r;
}

struct RowRange {  // in texels of one column: whole and part of both ends
  ivec2 texel;
  vec2 part;
};

RowRange row_range(vec2 rows, Streak streak, int view, int texels) {
  RowRange range;
  for (int i = 0; i < 2; ++i) {
    float row = cell_row(rows[i], streak.path_rows, atlas_views[view].y);
    row = clamp(row, 0.0, float(texels));
    range.texel[i] = min(int(row), texels - 1);
    range.part[i] = row - float(range.texel[i]);
  }
  return range;
}

float sum_between(RowRange range, int first) {
  ivec2 i = first + range.texel;
  float start = mix(cumulative(i.x), cumulative(i.x + 1), range.part.x);
  return mix(cumulative(i.y), cumulative(i.y + 1), range.part.y) - start;
}

// Rows between which the line `offset + t row` (relative to the pixel's centre) is inside the
// pixel.
vec2 rows_inside(vec2 offset, vec2 row) {
  vec2 direction = mix(row, vec2(1e-9), lessThan(abs(row), vec2(1e-9)));
  vec2 a = (-0.5 - offset) / direction, b = (0.5 - offset) / direction;
  vec2 low = min(a, b), high = max(a, b);
  vec2 rows = vec2(max(low.x, low.y), min(high.x, high.y));
  // A line through a corner has no length there: take the density around it. 0.02 px is below
  // anything visible and keeps the difference of sums above their rounding.
  float middle = 0.5 * (rows.x + rows.y);
  float half_length = max(0.5 * (rows.y - rows.x), 0.02 / length(row));
  return vec2(middle - half_length, middle + half_length);
}

// The streak's edges across a pixel, as half_plane_area wants them.
struct Across {
  float centre;         // the pixel's centre, in columns
  float px_per_column;
  vec2 normal;          // a >= b >= 0
#if LENS
  vec2 bar;             // of rain_defocus.glsl: its sides, in pixels beside; the disc's radius
  float radius_px;      // there, 0 for a sharp streak; pieces of a column
  int pieces;
#endif
};
#if LENS
float bar_share(Across across, float low, float high);
#endif

float strip_area(Across across, vec2 strip) {
  vec2 d = (strip - across.centre) * across.px_per_column;
  return half_plane_area(d.y, across.normal.x, across.normal.y) -
         half_plane_area(d.x, across.normal.x, across.normal.y);
}

// Pixel area of the light of one column, over the light's width. Narrower than 1e-3 columns is as
// good as a line, and no line may be narrower than its float coordinates tell.
float lit_area(Across across, vec2 strip, float centre, float half_width) {
  half_width = max(half_width, 1e-3);
  float width = strip.y - strip.x;
  vec2 narrowed = strip.x + width * vec2(centre - half_width, centre + half_width);
#if LENS
  if (across.radius_px > 0.0) return bar_share(across, narrowed.x, narrowed.y);
#endif
  return strip_area(across, narrowed) / (2.0 * half_width);
}

// Pixel area x mean of one column of a cell.
float cell_value(RowRange range, Across across, vec2 strip, int first, int texels, bool mirrored) {
  float centre = cumulative(first + texels + 1), half_width = cumulative(first + texels + 2);
  if (mirrored) centre = 1.0 - centre;
  return lit_area(across, strip, centre, half_width) * sum_between(range, first);
}

#if SKY_CELLS > 1
vec4 sky_cumulative(int i) {
  return texelFetch(sky_sums, place_of_sum(i), 0);
}

vec4 sky_between(RowRange range, int first) {
  ivec2 i = first + range.texel;
  vec4 start = mix(sky_cumulative(i.x), sky_cumulative(i.x + 1), range.part.x);
  return mix(sky_cumulative(i.y), sky_cumulative(i.y + 1), range.part.y) - start;
}

// The sky's radiance in one column, x pixel area, after see_sky.
vec3 sky_sum(Streak streak, RowRange range, int column, int view, Across across, vec2 strip) {
  ivec4 span = sky_spans[level_of(streak) * counts.w + view];
  const int quads = (SKY_CELLS + 3) / 4;
  int first = span.x + layer_of(streak) * quads * span.z + column * (span.y + 3);
  vec3 sum = vec3(0);
  for (int quad = 0; quad < quads; ++quad) {
    vec4 between = sky_between(range, first + quad * span.z);
    for (int i = 0; i < min(4, SKY_CELLS - 4 * quad); ++i)
      sum += between[i] * sky_seen[4 * quad + i];
  }
  float centre = sky_cumulative(first + span.y + 1).x;
  return lit_area(across, strip, centre, sky_cumulative(first + span.y + 2).x) * sum;
}
#endif

// rgb: radiance, a: coverage of one column of texels between two rows, x pixel area.
vec4 column_sum(Streak streak, vec2 rows, int column, int view, Across across, vec2 strip) {
  ivec4 span = atlas_spans[level_of(streak) * counts.w + view];  // base, texels, cell stride, columns
  RowRange range = row_range(rows, streak, view, span.y);
  int cells = cells_per_layer(), pitch = span.y + 3;
  int plain = span.x + column * pitch;
  vec4 sum = vec4(0);
#if TRACED
  int mirrored = span.x + (span.w - 1 - column) * pitch;
  int lit_first = streak_index * lit_per_streak();
  for (int i = 0; i < lit_per_streak(); ++i) {
    LitStreak lit = lit_streaks[lit_first + i];
    int layer_cell = int(lit.cell >> 16) * cells + int(lit.cell >> 1 & 0x7fffu);
    bool flip = (lit.cell & 1u) != 0u;
    int first = (flip ? mirrored : plain) + layer_cell * span.z;
    sum.rgb += vec3(lit.red, lit.green, lit.blue) *
               cell_value(range, across, strip, first, span.y, flip);
  }
#endif
#if SKY_CELLS > 1
  sum.rgb += sky_sum(streak, range, column, view, across, strip);
#endif
  int coverage_cell = layer_of(streak) * cells + cells - 1;
  sum.a = cell_value(range, across, strip, plain + coverage_cell * span.z, span.y, false);
  return sum;
}

vec4 strip_value(Streak streak, vec2 pixel_place, vec2 strip, int column, float reach) {
  vec2 normal = abs(streak.row_px) / length(streak.row_px);
  Across across;
  across.centre = pixel_place.x;
  across.px_per_column = abs(cross2(streak.column_px, streak.row_px)) / length(streak.row_px);
  across.normal = vec2(max(normal.x, normal.y), min(normal.x, normal.y));
#if LENS
  across.radius_px = 0.0;
#endif
  if (!(strip_area(across, strip) > 0.0)) return vec4(0);
  // The centre of that part of the strip which meets the pixel: its line crosses the pixel.
  float centre = 0.5 * (max(strip.x - pixel_place.x, -reach) + min(strip.y - pixel_place.x, reach));
  vec2 rows = pixel_place.y + rows_inside(centre * streak.column_px, streak.row_px);
  float per_row = 1.0 / (rows.y - rows.x);
  rows = min(rows, streak.clip_row);
  vec4 sum = streak.view_weight.x *
             column_sum(streak, rows, column, streak.view.x, across, strip);
  if (streak.view_weight.y > 0.0)
    sum += streak.view_weight.y * column_sum(streak, rows, column, streak.view.y, across, strip);
  return per_row * sum;
}

#if LENS
#include "rain_defocus.glsl"
#endif

void main() {
  Streak streak = streaks[streak_index];
  vec2 offset = gl_FragCoord.xy - streak.origin_px;
  float determinant = cross2(streak.column_px, streak.row_px);
  vec2 pixel_place = vec2(cross2(offset, streak.row_px), cross2(streak.column_px, offset)) /
                     determinant;
  // Half the pixel's extent in columns.
  float reach = 0.5 * (abs(streak.row_px.x) + abs(streak.row_px.y)) / abs(determinant);
  float texel = exp2(float(level_of(streak)));
#if LENS
  float circle = circle_px(streak.depth_m);
  bool sharp = circle <= least_circle_px;
  Defocus lens = defocus_of(streak, circle, texel);
  if (!sharp) reach = (lens.radius_px + 0.5) / abs(lens.px_per_column);
#endif
  int last_column = int(cell.y / texel + 0.5) - 1;
  int first = max(int(floor((pixel_place.x - reach) / texel)), 0);
  int last = min(int(floor((pixel_place.x + reach) / texel)), last_column);
  vec4 sum = vec4(0);
#if SKY_CELLS > 1
  see_sky(sky_streaks[streak_index]);
#endif
  for (int column = first; column <= last; ++column) {
    vec2 strip = texel * vec2(column, column + 1);
#if LENS
    if (!sharp) {
      sum += defocused_strip(streak, lens, pixel_place, strip, column);
      continue;
    }
#endif
    sum += strip_value(streak, pixel_place, strip, column, reach);
  }
#if SKY_CELLS > 1
  sum.rgb = max(sum.rgb, vec3(0));  // raytrace/sky_light.h
#endif
  // Added up by the blender in the order of the streaks: GL keeps the order of primitives within a
  // pixel, so float sums come out the same whatever the number of threads.
  float weight = mean_field_weight(streak.depth_m);
  sum.a = max(sum.a, 0.0);  // differences of sums may round below
#if !TRACED
  LitStreak lit = lit_streaks[streak_index];
  sum.rgb = sum.a * vec3(lit.red, lit.green, lit.blue);
  sum.a *= float(HIDDEN_SHARE);
#endif
  radiance_and_tau = vec4(weight * sum.rgb, optical_depth(sum.a, streak.counts_for));
  weighted_coverage = weight * covered(sum.a, streak.counts_for);
}
