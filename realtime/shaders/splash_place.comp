#version 450 core
// Strokes of the splashes of a group of drops, in order: counted where PLACE is 0, written where it
// is 1. A splash is a function of its drop and of the time since the hit (raytrace/splash.h,
// raytrace/splash_space.h).
#include "rain_group.glsl"
#include "rain_picture.glsl"
#include "rain_placement.glsl"
#include "rain_rank.glsl"
#include "splash_inputs.glsl"
#include "splash_strokes.glsl"
#if PLACE
#include "shadows.glsl"
layout(std430, binding = GROUP_STARTS) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = STROKES) writeonly buffer Strokes { Stroke strokes[]; };
layout(std430, binding = PHASE) readonly buffer Phase { float phase[]; };
#else
layout(std430, binding = GROUP_STARTS) writeonly buffer GroupCounts { uint group_counts[]; };
#endif
// Of each group the drops that splash, in order: (strokes before it in the group) << 8 | drop, and
// no_hit after the last. Counting finds them for placing.
layout(std430, binding = HITS) buffer Hits { uint group_hits[]; };
const uint no_hit = 0xffffffffu;
#if !PLACE
const uint no_end = 0xffffffffu;  // where there is nothing to write, there is room
#endif

layout(local_size_x = GROUP_SIZE) in;

const float pi = 3.14159265358979;
const float crown_steps = 8.0;       // of its life, each a straight stroke
const float droplet_step_s = 0.02;   // 0.5 mm of a parabola's bend
// A stroke covers about so much of a pixel where several droplets are drawn as one.
const float least_area_px = 0.005;

struct Hit {
  vec3 place_m, normal, velocity_m_s;
  mat3 axes;       // of the surface, turned; z along the normal
  float cosine, since_s;
  int size, variant;
};

// Whether the fall that leads to a place has come through the rain's box.
bool through_box(vec3 place_m, vec3 against_fall) {
  vec3 way = mix(against_fall, vec3(1e-20), equal(against_fall, vec3(0)));
  vec3 a = (fall_box_min_m.xyz - place_m) / way, b = (fall_box_max_m.xyz - place_m) / way;
  vec3 low = min(a, b), high = max(a, b);
  return max(max(low.x, low.y), max(low.z, 0.0)) < min(high.x, min(high.y, high.z));
}

mat3 surface_axes(vec3 z, float turn) {
  vec3 hint = abs(z.x) < 0.9 ? vec3(1, 0, 0) : vec3(0, 1, 0);
  vec3 x = normalize(hint - dot(hint, z) * z), y = cross(z, x);
  return mat3(cos(turn) * x + sin(turn) * y, cos(turn) * y - sin(turn) * x, z);
}

bool find_hit(uint group_number, uint place_in_group, out Hit hit) {
  Drop drop;
  if (!drop_at(group_number, place_in_group, drop)) return false;
  DropGroup group = drop_groups[group_number];
  RainSize size = rain_sizes[drop.size];
  SplashSize splash = splash_sizes[drop.size];
  hit.since_s = -drop.hit_time_s;
  if (!(hit.since_s < splash.impact.w && hit.since_s > -splash_air.x)) return false;
  hit.velocity_m_s = velocity_of(drop);
  hit.place_m = drop.centre_m - hit.since_s * hit.velocity_m_s;
#if !MOTION
  if (group.what.y < 0 && !through_box(hit.place_m, size.axis_z.xyz)) return false;
#endif
#if MOTION
  vec3 moved = hit.place_m - group.corner_m.xyz;
  // Drops that end at a wall or inside a solid throw nothing up.
  float above_m = group.corner_top.z + moved.z - surface_m(size, group.corner_top.xy + moved.xy);
  if (group.what.y < 0 && abs(above_m) > 0.1) return false;
#else
  vec3 moved = drop.centre_m - group.corner_m.xyz;
#endif
  vec2 beside_m;
  int texel = top_texel(size, group.corner_top.xy + vec2(dot(moved, size.axis_x.xyz),
                                                         dot(moved, size.axis_y.xyz)), beside_m);
  if (texel < 0) return false;
  hit.normal = normalize(size.axis_z.xyz - top_heights[texel + 1] * size.axis_x.xyz -
                         top_heights[texel + 2] * size.axis_y.xyz);
  hit.cosine = dot(hit.normal, size.axis_z.xyz);
  hit.size = drop.size;
  // drop.layer: 16 bits of the drop's own.
  uvec3 bits = rain_hash(uvec3(uint(drop.layer), 0u, 0u));
  hit.variant = int(bits.x % SPLASH_VARIANTS);
  hit.axes = surface_axes(hit.normal, 2.0 * pi * fraction(bits.y));
  return true;
}

vec3 bead_place(SplashSize splash, SplashPart bead, Hit hit, float time_s) {
  float age = time_s / splash.crown.x;
  float radius_m = mix(splash.crown.z, splash.crown.w, age * (2.0 - age));
  return hit.axes * vec3(radius_m * bead.first.xy,
                         hit.cosine * splash.crown.y * bead.first.z * 4.0 * age * (1.0 - age));
}

vec3 droplet_place(SplashPart part, Hit hit, float time_s) {
  float drag_s = part.velocity.w, t = time_s - part.more.x;
  vec3 slide = hit.velocity_m_s - dot(hit.velocity_m_s, hit.normal) * hit.normal;
  vec3 launch = hit.cosine * (hit.axes * part.velocity.xyz) + SPLASH_DRIFT * slide;
  vec3 falling = vec3(0, 0, -splash_air.y * drag_s);
  return hit.axes * part.first.xyz + (launch - falling) * drag_s * (1.0 - exp(-t / drag_s)) +
         falling * t;
}

struct Path {  // of a part, from the point that was hit; a share of the exposure
  vec3 from_m, to_m;
  float share;
};

// The part's path between two times since the hit, as far as it is above the surface.
bool path_of(SplashSize splash, SplashPart part, Hit hit, float from_s, float to_s,
             out Path path) {
  bool bead = part.velocity.w == 0.0;
  from_s = max(from_s, part.more.x);
  if (!(from_s < to_s)) return false;
  path.from_m = bead ? bead_place(splash, part, hit, from_s) : droplet_place(part, hit, from_s);
  path.to_m = bead ? bead_place(splash, part, hit, to_s) : droplet_place(part, hit, to_s);
  path.share = (to_s - from_s) / splash_air.x;
  float from_height = dot(path.from_m, hit.normal), to_height = dot(path.to_m, hit.normal);
  if (!(from_height > 0.0 || to_height > 0.0)) return false;
  if (to_height < 0.0) {
    float above = from_height / (from_height - to_height);
    path.to_m = mix(path.from_m, path.to_m, above);
    path.share *= above;
  }
  return path.share > 0.0;
}

// Merged: how many droplets' area it stands for. False where the picture does not show it.
bool stroke_of(Path path, Hit hit, float radius_m, float merged, out Stroke stroke) {
  vec3 a = in_camera(hit.place_m + path.from_m), b = in_camera(hit.place_m + path.to_m);
  if (min(a.z, b.z) < nearest_depth_m) return false;
  vec2 a_px = project(a), b_px = project(b);
  float radius_px = camera_right.w * radius_m / (0.5 * (a.z + b.z));
  float length_px = distance(a_px, b_px);
  vec2 along = length_px > 0.0 ? (b_px - a_px) / length_px : vec2(1, 0);
  stroke.centre_px = 0.5 * (a_px + b_px);
  // A disc's variance is a quarter of its squared radius, a rectangle's a twelfth of its squared
  // side.
  float disc_px2 = radius_px * radius_px;
  float before_m = 0.01;  // the surface below does not hide what leaves it
#if LENS
  float circle = circle_px(0.5 * (a.z + b.z));
  disc_px2 += circle * circle;
  // Nor where the circle lies over nearer parts of it.
  float facing = max(-dot(in_camera(hit.normal), normalize(a + b)), 0.05);
  before_m += circle * 0.5 * (a.z + b.z) / (camera_right.w * facing);
#endif
  stroke.half_axis_px = 0.5 * sqrt(length_px * length_px + 3.0 * disc_px2) * along;
  stroke.half_width_px = max(0.5 * sqrt(3.0 * disc_px2), 5e-4);
  stroke.area_px = pi * radius_px * radius_px * merged * path.share;
  stroke.inverse_depth = NEAR_M / max(min(a.z, b.z) - radius_m - before_m, NEAR_M);
  stroke.weight = mean_field_weight(0.5 * (a.z + b.z));
  vec2 reach = abs(stroke.half_axis_px) + stroke.half_width_px + 1.0;
  return all(greaterThan(stroke.centre_px + reach, vec2(0))) &&
         all(lessThan(stroke.centre_px - reach, vec2(camera_up.w, camera_forward.w)));
}

#if PLACE
float phase_at(float cosine) {
  float place = acos(clamp(cosine, -1.0, 1.0)) / pi * float(phase.length()) - 0.5;
  int low = clamp(int(floor(place)), 0, phase.length() - 2);
  return mix(phase[low], phase[low + 1], clamp(place - float(low), 0.0, 1.0));
}

// Of a droplet's disc: E P toward the camera for every light, and the environment's mean.
vec3 radiance_at(vec3 place_m) {
  vec3 toward_camera = -normalize(place_m);
  vec3 sum = environment.rgb;
  for (int i = 0; i < counts.y; ++i) {
    Illumination lit = illumination(lights[i], place_m);
    float texel_m = lights[i].more.w * (lights[i].place.w == 0.0 ? 1.0 : lit.distance_m);
    float share =
        lit_share(lights[i], place_m + camera_m.xyz + 2.0 * texel_m * lit.toward, lit.toward);
    sum += lit.lux * share * phase_at(dot(-lit.toward, toward_camera));
  }
  return exp(-air.x * length(place_m)) * sum;
}
#endif

// What a part shows between two times since the hit. next: the bead beside it where the rim is drawn
// whole, as a thread from bead to bead that moves sideways; else the part itself.
bool stroke_between(SplashSize splash, SplashPart part, SplashPart next, Hit hit, float from_s,
                    float to_s, float merged, out Stroke stroke, out vec3 middle_m) {
  Path path, beside;
  if (!path_of(splash, part, hit, from_s, to_s, path)) return false;
  middle_m = hit.place_m + 0.5 * (path.from_m + path.to_m);
  if (part.velocity.w != 0.0 || next.first == part.first)
    return stroke_of(path, hit, part.first.w, merged, stroke);
  if (!path_of(splash, next, hit, from_s, to_s, beside)) return false;
  Path rim = Path(0.5 * (path.from_m + path.to_m), 0.5 * (beside.from_m + beside.to_m), path.share);
  // The bead's area, drawn out to a thread half as thick.
  if (!stroke_of(rim, hit, 0.5 * part.first.w, 4.0 * merged, stroke)) return false;
  vec2 moved = projected_derivative(in_camera(middle_m), in_camera(path.to_m - path.from_m));
  vec2 along = normalize(stroke.half_axis_px);
  float sideways_px = moved.x * along.y - moved.y * along.x;
  stroke.half_width_px = length(vec2(stroke.half_width_px, 0.5 * sideways_px));
  return true;
}

// Strokes of `count` parts that stand for `all`, as far as there is room before `end`; returns the
// next free place.
uint add_parts(SplashSize splash, Hit hit, int first, int count, int all, float step_s, uint next,
               uint end) {
  if (count == 0) return next;
  float merged = splash_parts[first + all - 1].more.y / splash_parts[first + count - 1].more.y;
  float begin_s = max(hit.since_s, 0.0), end_s = min(hit.since_s + splash_air.x, splash.impact.w);
  bool rim = splash_parts[first].velocity.w == 0.0;
  float last_s = rim ? min(end_s, splash.crown.x) : end_s;
  for (int i = 0; i < count; ++i) {
    // Beads stand in a ring: a few of them are taken from all around.
    int place = rim ? i * 13 % all : i;
    SplashPart part = splash_parts[first + place];
    SplashPart beside = splash_parts[first + (count == all ? (place + 1) % all : place)];
    for (float step = floor(begin_s / step_s); step * step_s < last_s; step += 1.0) {
      Stroke stroke;
      vec3 middle_m;
      if (!stroke_between(splash, part, beside, hit, max(step * step_s, begin_s),
                          min((step + 1.0) * step_s, last_s), merged, stroke, middle_m))
        continue;
      if (next == end) return next;
#if PLACE
      stroke.radiance = vec4(radiance_at(middle_m), 0);
      strokes[next] = stroke;
#endif
      ++next;
    }
  }
  return next;
}

// As few as cover least_area_px each.
int drawn_parts(int first, int all, float px_per_m) {
  if (all == 0) return 0;
  float area_px = pi * px_per_m * px_per_m * splash_parts[first + all - 1].more.y;
  return clamp(int(ceil(area_px / least_area_px)), 1, all);
}

uint add_splash(Hit hit, uint next, uint end) {
  SplashSize splash = splash_sizes[hit.size];
  float weber = splash.impact.x * hit.cosine * hit.cosine;
  float mean = splash.impact.z * (weber / splash.impact.y - 1.0);
  if (!(mean > 0.0)) return next;
  mean = min(mean, float(MOST_DROPLETS));
  float rounding = (float(hit.variant) + 0.5) / float(SPLASH_VARIANTS);
  int droplets = min(int(mean + rounding), splash.parts.y);
  int beads = splash.parts.x + hit.variant * (CROWN_BEADS + splash.parts.y);
  float depth_m = max(dot(hit.place_m, camera_forward.xyz), nearest_depth_m);
  float px_per_m = camera_right.w / depth_m;
  next = add_parts(splash, hit, beads, drawn_parts(beads, CROWN_BEADS, px_per_m), CROWN_BEADS,
                   splash.crown.x / crown_steps, next, end);
  int flying = beads + CROWN_BEADS;
  return add_parts(splash, hit, flying, drawn_parts(flying, droplets, px_per_m), droplets,
                   droplet_step_s, next, end);
}

#if PLACE
void main() {
  uint i = gl_LocalInvocationID.x;
  if (group_index() >= uint(sizes.x)) return;
  uint at = group_index() * GROUP_SIZE + i, first = group_starts[group_index()];
  uint found = group_hits[at];
  if (found == no_hit) return;
  // Counted by another program, which may have rounded otherwise: never into the next one's room.
  bool last = i + 1u == GROUP_SIZE || group_hits[at + 1u] == no_hit;
  uint end = last ? group_starts[group_index() + 1u] : first + (group_hits[at + 1u] >> 8);
  uint next = first + (found >> 8);
  Hit hit;
  if (find_hit(group_index(), found & 0xffu, hit)) next = add_splash(hit, next, end);
  for (; next < end; ++next) strokes[next].inverse_depth = no_stroke;
}
#else
shared uint hits[GROUP_SIZE];
shared uint counted[GROUP_SIZE];

void main() {
  uint i = gl_LocalInvocationID.x, total;
  if (group_index() >= uint(sizes.x)) return;
  Hit hit;
  // Few drops splash: the first threads take those, side by side.
  bool is_hit = find_hit(group_index(), i, hit);
  uint rank = rank_in_group(is_hit, total);
  if (is_hit) hits[rank] = i;
  barrier();
  bool has_one = i < total && find_hit(group_index(), hits[i], hit);
  counted[i] = has_one ? add_splash(hit, 0u, no_end) : 0u;
  barrier();
  // One by one: they are few, and a barrier costs a software rasteriser more than a sum.
  uint before = 0u;
  if (i < total) {
    for (uint k = 0u; k < i; ++k) before += counted[k];
  }
  group_hits[group_index() * GROUP_SIZE + i] = i < total ? before << 8 | hits[i] : no_hit;
  if (i + 1u == max(total, 1u)) group_counts[group_index()] = before + counted[i];
}
#endif
