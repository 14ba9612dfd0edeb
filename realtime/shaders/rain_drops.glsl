// The rain's drops at shutter-open.
#include "rain_hash.glsl"
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

struct Drop {
  vec3 centre_m;     // at shutter-open, from the camera
  int layer;         // of the atlas: its oscillation set
  float hit_time_s;  // <= 0: not to be drawn
  int size;
  int segment;
  float counts_for;  // drops
#if MOTION
  vec3 velocity_m_s;
#endif
};

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

// drop_at, velocity_of and against_fall: by the closed form, or of drops that are moved by steps.
#include DROPS
