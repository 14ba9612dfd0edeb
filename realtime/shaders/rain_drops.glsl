// Drops as a function of seed and time: the closed form of raytrace/rain_space.h.
#include "rain_uniforms.glsl"

struct DropGroup {  // what DROPS_OF_GROUP threads work on: drops of one cell, or one single drop
  vec4 corner_m;    // of the cell at the slab's lower end, or the drop's centre; from the camera. w:
                    // for how many each counts (realtime/far_field.h)
  vec4 corner_top;  // the corner in the frame's x, y and z, as the top heights know them. w: drops of
                    // the cell that count, the last by its fraction
  vec4 corner_density;  // in texels of the density map
  uvec4 drops;      // the cell's two keys; first and number of its drops and segments
  ivec4 what;       // size; oscillation set of a single drop, else -1; the cell's third key
};
layout(std430, binding = DROP_GROUPS) readonly buffer DropGroups { DropGroup drop_groups[]; };
layout(std430, binding = TOP_HEIGHTS) readonly buffer TopHeights { float top_heights[]; };

#if DENSITY
layout(std430, binding = DENSITIES) readonly buffer Densities { float densities[]; };
#endif

struct Drop {
  vec3 centre_m;     // at shutter-open, from the camera
  int layer;         // of the atlas: its oscillation set
  float hit_time_s;  // <= 0: not to be drawn
  int size;
  int segment;
  float counts_for;  // drops
};

uvec3 rain_hash(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

float fraction(uint bits) { return float(bits) * (1.0 / 4294967296.0); }

// Where the texel below a point of the frame's plane begins in top_heights; -1 outside the grid.
int top_texel(RainSize size, vec2 place_m, out vec2 beside_m) {
  vec2 texel = floor((place_m - size.top_grid.xy) / size.top_grid.z);
  if (any(lessThan(texel, vec2(0))) || any(greaterThanEqual(texel, vec2(size.top_layout.yz))))
    return -1;
  beside_m = place_m - size.top_grid.xy - (texel + 0.5) * size.top_grid.z;
  return size.top_layout.x + 3 * (int(texel.y) * size.top_layout.y + int(texel.x));
}

// Height of the surface below a point of the frame's plane.
float surface_m(RainSize size, vec2 place_m) {
  vec2 beside_m;
  int first = top_texel(size, place_m, beside_m);
  if (first < 0) return size.top_grid.w;
  return top_heights[first] + beside_m.x * top_heights[first + 1] +
         beside_m.y * top_heights[first + 2];
}

#if DENSITY
// The share of the rain that falls there.
float density_share(vec2 texel) {
  ivec2 at = ivec2(floor(texel));
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, density.xy))) return 0.0;
  return densities[at.y * density.x + at.x];
}
#endif

// False where there is no such drop, or it is outside the rain's box.
bool drop_at(uint group_number, uint place_in_group, out Drop drop) {
  if (group_number >= uint(sizes.x)) return false;
  DropGroup group = drop_groups[group_number];
  if (place_in_group >= group.drops.w) return false;
  RainSize size = rain_sizes[group.what.x];
  uint item = group.drops.z + place_in_group, segments = size.run.z;
  uint k = item / segments;
  drop.size = group.what.x;
  drop.segment = int(item - k * segments);
  drop.counts_for = group.corner_m.w * clamp(group.corner_top.w - float(k), 0.0, 1.0);
  vec3 moved = vec3(0);  // in the frame
  drop.layer = group.what.y;
  if (group.what.y < 0) {
    uint start = rain_hash(uvec3(group.drops.x, k, 0u)).x;
    uint up = start - size.run.x;
    uint round_number = size.run.y + (start < size.run.x ? 1u : 0u);
    uvec3 place = rain_hash(uvec3(group.drops.y, k, round_number));
    moved = vec3(size.axis_x.w * fraction(place.x), size.axis_x.w * fraction(place.y),
                 size.axis_y.w * fraction(up));
#if DENSITY
    vec2 texel = group.corner_density.xy + moved.x * size.density_axes.xy +
                 moved.y * size.density_axes.zw;
    uvec3 thin = rain_hash(uvec3(uint(group.what.z), k, round_number));
    if (!(fraction(thin.x) < density_share(texel))) return false;
#endif
    uint set, low;
    umulExtended(place.z, uint(counts.x), set, low);
    drop.layer = int(set);
  }
  drop.centre_m = group.corner_m.xyz + moved.x * size.axis_x.xyz + moved.y * size.axis_y.xyz +
                  moved.z * size.axis_z.xyz;
  vec3 in_frame = group.corner_top.xyz + moved;
  drop.hit_time_s = (in_frame.z - surface_m(size, in_frame.xy)) / size.times.w;
  return group.what.y >= 0 || (all(greaterThanEqual(drop.centre_m, box_min_m.xyz)) &&
                               all(lessThanEqual(drop.centre_m, box_max_m.xyz)));
}
