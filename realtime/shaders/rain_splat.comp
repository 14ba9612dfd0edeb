#version 450 core
// Thin streaks, straight into the picture: no record, no quad, no fragment. Also counts the others.
//
// A thin streak is a line with its light beside it: at each place down the streak a flux, and where
// across it lies in the mean and how far around (realtime/streak_profiles.h). The line is walked
// from one border of pixels to the next; between two of them it lays its flux
//   F = F(row at the far border) - F(row at the near one)
// evenly over the stretch of pixels that it covers across: a box with the mean and variance of what
// the line's slant and the light's own width make of it. Sums of all lights are walked together. A
// streak wider than `joined_px` is two lines, its left half and its right. What two steps or halves
// lay into one pixel hides itself there like two streaks: up to 0.9 % too little optical depth, and
// 0.4 % too little light, at the shortest exposures; 0.1 % at 1/60 s.
//
// A streak a little out of focus (rain_lens.glsl) is widened by its circle's variance; its ends are
// not.
//
// Sums are integers, so that they come out the same in any order: values are counted in quanta and
// rounded up or down by chance (a hash of drop and pixel), in the mean to what they are. Very
// bright streaks are left to quads; where a value or a sum is beyond 2^30 quanta all the same,
// splat_overflow says so, and the frame is drawn by quads alone.
#include "rain_group.glsl"
#include "rain_picture.glsl"
#include "rain_rank.glsl"
#include STREAK_LIGHT

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = GROUP_STARTS) writeonly buffer GroupCounts { uint group_counts[]; };
layout(std430, binding = SPLAT_SUMS) buffer SplatSums {
  int splat_sums[];  // five for each pixel: weighted red, green, blue; tau; weighted coverage
};
// Apart from the sums: what the processor reads, a driver may keep where it is slow to add to.
layout(std430, binding = SPLAT_OVERFLOW) buffer SplatOverflow { uint splat_overflow; };
layout(std430, binding = PROFILE_SPANS) readonly buffer ProfileSpans { ivec4 profile_spans[]; };
layout(binding = PROFILES) uniform sampler2DArray profiles;
layout(binding = SCENE_DEPTH) uniform sampler2D scene_depth_m;

const int most_quanta = 1 << 30;
const float joined_px = 0.1;  // 0.3 errs by 0.047 in far rain, 0.1 by 0.0095, as two halves do

const int whole = 0, left_half = 1, right_half = 2;  // of a streak: what a line stands for
const float half_place = 0.2;  // across a cell, from its middle: where a half's line is

int profile_cells() { return counts.z + SKY_CELLS + 1; }

#if TRACED
// Lights are taken SPLAT_LIGHTS at a time; each has TAPS cells of the atlas. The sky comes last,
// coverage by itself.
struct Lit {
  vec3 weight;
  int cell;  // of a view, << 1 | mirrored
};
Lit lits[SPLAT_LIGHTS * TAPS + SKY_CELLS];
int lit_count;

void keep_lit(uint place, vec3 lux, uint cell) {
  int of_view = int(cell >> 16) * profile_cells() + int(cell >> 1 & 0x7fffu);
  lits[place] = Lit(lux, of_view << 1 | int(cell & 1u));
}
#else
vec3 radiance;  // of all of the streak that this thread walks
#endif

vec4 profile(int i) {
  return texelFetch(profiles, ivec3(i & SUMS_WIDTH - 1, i / SUMS_WIDTH & SUMS_HEIGHT - 1,
                                    i / (SUMS_WIDTH * SUMS_HEIGHT)), 0);
}

vec3 profile_at(int at, float share) { return mix(profile(at), profile(at + 2), share).xyz; }

struct ThinStreak {
  ivec2 view;
  vec2 view_weight;
  int layer, level;  // of profile_spans
  float path_rows, clip_row;
  int part;
  bool covers;  // false when coverage has been laid down with other lights
};

int coverage_cell(ThinStreak streak) { return (streak.layer + 1) * profile_cells() - 1; }

// A place down a cell of a view: its bin, and the share of that bin before it.
struct Place {
  int bin;
  float share;
};

Place place_of(ThinStreak streak, int view, float row, ivec4 span) {
  float place = cell_row(min(row, streak.clip_row), streak.path_rows, atlas_views[view].y);
  place = clamp(place, 0.0, float(span.w));
  float rows = exp2(float(splat_levels.x + streak.level));  // of a bin; the last may have fewer
  int bin = min(int(place / rows), span.y - 1);
  float begin = float(bin) * rows;
  return Place(bin, min((place - begin) / min(rows, float(span.w) - begin), 1.0));
}

// Flux, flux times place across, flux times its square, of a part of a cell before a place.
vec3 flux_before(ivec4 span, int cell, bool mirrored, int part, Place place) {
  int at = span.x + cell * span.z + 2 * place.bin;
  vec3 sum = vec3(0);
  if (part != left_half || mirrored) sum = profile_at(at, place.share);
  if (part != whole) {
    vec3 left = profile_at(at + 1, place.share);
    sum = (part == left_half) != mirrored ? left : sum - left;
  }
  return mirrored ? sum * vec3(1, -1, 1) : sum;
}

// What a part of a streak has before a row: light, the same of red, green and blue together as
// flux_before has it, and coverage. Without TRACED light goes with coverage.
struct Before {
#if TRACED
  vec3 light, grey;
#endif
  vec3 coverage;
};

void add_before(ThinStreak streak, int view, float weight, float row, inout Before sum) {
  ivec4 span = profile_spans[streak.level * counts.w + view];
  Place place = place_of(streak, view, row, span);
#if TRACED
  for (int i = 0; i < lit_count; ++i) {
    vec3 flux = flux_before(span, lits[i].cell >> 1, (lits[i].cell & 1) != 0, streak.part, place);
    vec3 light = weight * lits[i].weight;
    sum.light += flux.x * light;
    sum.grey += (light.r + light.g + light.b) * flux;
  }
#endif
  if (streak.covers)
    sum.coverage += weight * flux_before(span, coverage_cell(streak), false, streak.part, place);
}

Before before_row(ThinStreak streak, float row) {
#if TRACED
  Before sum = Before(vec3(0), vec3(0), vec3(0));
#else
  Before sum = Before(vec3(0));
#endif
  add_before(streak, streak.view.x, streak.view_weight.x, row, sum);
  if (streak.view_weight.y > 0.0)
    add_before(streak, streak.view.y, streak.view_weight.y, row, sum);
  return sum;
}

#if LENS
// Of a circle, beside the line: its variance, a quarter of its radius squared, along the slanted
// line onto the axis beside.
float lens_variance_px2;
#endif

// A stretch of pixels across the line, evenly covered.
struct Box {
  float centre, half_length;
};

// flux: as flux_before has it. middle: across, of where `line` is.
Box box_of(float line, float middle, float slant_px, vec3 flux, float px_per_cell) {
  float place = middle, variance = 1.0 / 48.0;
  if (flux.x > 0.0) {
    place = clamp(flux.y / flux.x, -0.5, 0.5);
    variance = clamp(flux.z / flux.x - place * place, 0.0, 0.25);
  }
  // Variances add up: an even box of half length h has h^2 / 3.
  float length_squared = 0.25 * slant_px * slant_px + 3.0 * variance * px_per_cell * px_per_cell;
#if LENS
  length_squared += 3.0 * lens_variance_px2;
#endif
  return Box(line + (place - middle) * px_per_cell, max(sqrt(length_squared), 1e-4));
}

// The part of a box before a place; differences of it lose nothing between neighbours.
float part_before(Box box, float place) {
  return clamp(0.5 + 0.5 * (place - box.centre) / box.half_length, 0.0, 1.0);
}

// The part of a box that lies between first and first + 1.
float share_of(Box box, float first) {
  return part_before(box, first + 1.0) - part_before(box, first);
}

// Of the streak that this thread walks.
uint rounding_key;
float depth_m, counts_for;

void add_quanta(int place, float quanta, float chance) {
  if (!(abs(quanta) < float(most_quanta))) {
    splat_overflow = 1u;
    return;
  }
  int whole = int(floor(quanta + chance));
  if (whole == 0) return;
  int before = atomicAdd(splat_sums[place], whole);
  if (abs(before) >= most_quanta) splat_overflow = 1u;
}

void add_to_pixel(ivec2 px, vec3 light, float coverage) {
  ivec2 picture = ivec2(camera_up.w, camera_forward.w);
  if (any(lessThan(px, ivec2(0))) || any(greaterThanEqual(px, picture))) return;
  if (!(depth_m < texelFetch(scene_depth_m, px, 0).r)) return;
  float weight = mean_field_weight(depth_m);
  float c = max(coverage, 0.0);
  int first = 5 * (px.y * picture.x + px.x);
  // One chance for both of a pair: composite.frag divides them.
  uvec3 chances = rain_hash(uvec3(rounding_key, px));
  float share_chance = fraction(chances.x ^ chances.y ^ chances.z);
  vec3 quanta = splat.z * weight * light;
  add_quanta(first, quanta.r, fraction(chances.x));
  add_quanta(first + 1, quanta.g, fraction(chances.y));
  add_quanta(first + 2, quanta.b, fraction(chances.z));
  add_quanta(first + 3, splat.w * optical_depth(c, counts_for), share_chance);
  add_quanta(first + 4, splat.w * weight * covered(c, counts_for), share_chance);
}

// The line of a streak's part on screen. along: the axis of the screen that it runs along most.
struct Line {
  vec2 start, row;
  int along, beside;
  float middle;       // across the cell, from its middle
  float px_per_cell;  // what the cell's width moves it beside
  float area_px;      // of a row of the cell
};

Line line_of(Placement placed, int part) {
  vec2 column = placed.column_px, row = placed.row_px;
  Line line;
  line.middle = part == whole ? 0.0 : part == left_half ? -half_place : half_place;
  line.start = placed.origin_px + (0.5 + line.middle) * cell.y * column;
  line.row = row;
  line.along = abs(row.y) >= abs(row.x) ? 1 : 0;
  line.beside = 1 - line.along;
  float twist = column.x * row.y - column.y * row.x;
  line.px_per_cell = (line.along == 1 ? twist : -twist) / row[line.along] * cell.y;
  line.area_px = abs(twist) * cell.y;
  return line;
}

// What lies between two rows, which no border of pixels parts.
void lay_down(Line line, float from, float to, Before before, Before after) {
  float middle = 0.5 * (from + to);
  float at = line.start[line.beside] + middle * line.row[line.beside];
  float slant_px = abs(line.row[line.beside]) * (to - from);
  vec3 cover = after.coverage - before.coverage;
  Box covered = box_of(at, line.middle, slant_px, cover, line.px_per_cell);
#if TRACED
  vec3 light = line.area_px * (after.light - before.light);
#if SKY_CELLS > 1
  light = max(light, vec3(0));  // raytrace/sky_light.h
#endif
  Box lit = box_of(at, line.middle, slant_px, after.grey - before.grey, line.px_per_cell);
#else
  vec3 light = line.area_px * max(cover.x, 0.0) * radiance;
  Box lit = covered;
  cover.x *= float(HIDDEN_SHARE);
#endif
  float low = min(lit.centre - lit.half_length, covered.centre - covered.half_length);
  float high = max(lit.centre + lit.half_length, covered.centre + covered.half_length);
  // No streak is wider: only a bound of the loop.
  float reach_px = abs(line.px_per_cell) + 1.0;
#if LENS
  reach_px += sqrt(3.0 * lens_variance_px2);
#endif
  int last = int(floor(min(high, at + reach_px)));
  ivec2 px;
  px[line.along] = int(floor(line.start[line.along] + middle * line.row[line.along]));
  for (int k = int(floor(max(low, at - reach_px))); k <= last; ++k) {
    px[line.beside] = k;
    add_to_pixel(px, share_of(lit, float(k)) * light,
                 share_of(covered, float(k)) * line.area_px * cover.x);
  }
}

void walk(ThinStreak streak, Line line) {
  vec2 start = line.start, row = line.row;
  // Rows within the picture.
  float picture = line.along == 1 ? camera_forward.w : camera_up.w;
  vec2 inside = (vec2(0, picture) - start[line.along]) / row[line.along];
  float t = max(min(inside.x, inside.y), 0.0);
  float end = min(end_row(streak.path_rows, streak.clip_row), max(inside.x, inside.y));
  if (!(t < end)) return;
  ivec2 border = ivec2(floor(start + t * row)) + ivec2(greaterThan(row, vec2(0)));
  ivec2 toward = ivec2(sign(row));
  Before before = before_row(streak, t);
  for (int i = 0; i < SPLAT_STEPS && t < end; ++i) {
    vec2 to_border = mix((vec2(border) - start) / row, vec2(never), equal(row, vec2(0)));
    // Never back: a border that rounding has put behind is passed at once.
    int nearer = to_border.x < to_border.y ? 0 : 1;
    float next = clamp(to_border[nearer], t, end);
    border[nearer] += toward[nearer];
    if (!(next > t)) continue;
    Before after = before_row(streak, next);
    lay_down(line, t, next, before, after);
    before = after;
    t = next;
  }
}

// The coarsest level whose bins are at most an eighth of a pixel long: half a pixel errs by 0.023,
// a quarter by 0.015, an eighth by 0.011 and what is finer by no less (far rain).
int profile_level(Placement placed) {
  float level = floor(log2(0.125 / length(placed.row_px)));
  return int(clamp(level - float(splat_levels.x), 0.0, float(splat_levels.y - 1)));
}

#if TRACED
void keep_sky(Drop drop, Placement placed, float transmitted) {
#if SKY_CELLS == 1
  keep_lit(uint(lit_count), transmitted * environment.rgb,
           cell_of(uint(counts.z), false, drop.layer));
#elif SKY_CELLS > 1
  see_sky(sky_of(drop, placed.frame, transmitted));
  for (int i = 0; i < SKY_CELLS; ++i)
    keep_lit(uint(lit_count + i), sky_seen[i], cell_of(uint(counts.z + i), false, drop.layer));
#endif
  lit_count += SKY_CELLS;
}
#endif

void walk_parts(ThinStreak streak, Placement placed) {
  bool joined = abs(line_of(placed, whole).px_per_cell) <= joined_px;
#if LENS
  Line middle = line_of(placed, whole);
  float slant = middle.row[middle.beside] / middle.row[middle.along];
  float circle = circle_px(depth_m);
  lens_variance_px2 = 0.25 * circle * circle * (1.0 + slant * slant);
#endif
  for (int part = joined ? whole : left_half; part <= (joined ? whole : right_half); ++part) {
    streak.part = part;
    walk(streak, line_of(placed, part));
  }
}

void splat_streak(Drop drop, Placement placed, uint place) {
  ThinStreak streak;
  streak.layer = drop.layer;
  streak.level = profile_level(placed);
  streak.path_rows = placed.path_rows;
  streak.clip_row = placed.clip_row;
  streak_views(drop, view_elevation_deg(placed), streak.view, streak.view_weight);
  depth_m = placed.depth_m;
  counts_for = drop.counts_for;
  rounding_key = drop_groups[drop_group_index()].drops.x ^ 0x9e3779b9u * (place + 1u);
#if TRACED
  float transmitted = exp(-air.x * length(placed.middle_m));
  for (int begin = 0; begin == 0 || begin < counts.y; begin += SPLAT_LIGHTS) {
    int taken = min(counts.y - begin, SPLAT_LIGHTS);
    for (int i = 0; i < taken; ++i)
      keep_light(uint(i * TAPS), lights[begin + i], drop, placed, transmitted);
    lit_count = taken * TAPS;
    if (begin == 0) keep_sky(drop, placed, transmitted);
    streak.covers = begin == 0;
    walk_parts(streak, placed);
  }
#else
  radiance = streak_radiance(drop, placed);
  streak.covers = true;
  walk_parts(streak, placed);
#endif
}

void main() {
  Drop drop;
  Placement placed;
  bool visible = drop_at(drop_group_index(), place_in_drop_group(), drop) &&
                 place_streak(drop, placed) && in_picture(placed);
  bool thin = visible && is_thin(placed);
  uint wide_total, thin_total;
  rank_in_group(visible && !thin, wide_total);
  barrier();
  rank_in_group(thin, thin_total);
  if (gl_LocalInvocationID.x == 0u && drop_group_index() < uint(sizes.x))
    group_counts[group_index()] = wide_total | thin_total << 16;
  if (thin) splat_streak(drop, placed, place_in_drop_group() + drop_groups[drop_group_index()].drops.z);
}
