// Drops as a function of seed and time: the closed form of raytrace/drop_field.h.
#include "rain_uniforms.glsl"

layout(binding = TOP_HEIGHT) uniform sampler2D top_height;

struct Drop {
  vec3 centre_m;     // at shutter-open, from the camera
  int layer;         // of the atlas: its oscillation set
  float hit_time_s;  // <= 0: not to be drawn
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

// Height of the surface below a point, from the camera.
float surface_m(vec2 place_m) {
  vec2 texel = floor((place_m - top_grid_m.xy) / top_grid_m.z);
  ivec2 size = textureSize(top_height, 0);
  if (any(lessThan(texel, vec2(0))) || any(greaterThanEqual(texel, vec2(size))))
    return top_grid_m.w;
  return texelFetch(top_height, ivec2(texel), 0).r;
}

Drop drop_at(uint k) {
  uint start = rain_hash(uvec3(fall.z, k, 0u)).x;
  uint phase = start + fall.x;
  uint round_number = fall.y + (phase < start ? 1u : 0u);
  uvec3 place = rain_hash(uvec3(fall.w, k, round_number));
  uint set, low;
  umulExtended(place.z, uint(sizes.x), set, low);
  Drop drop;
  drop.centre_m = box_corner_m.xyz +
                  box_size_m.xyz * vec3(fraction(place.x), fraction(place.y), -fraction(phase));
  drop.layer = int(set);
  drop.hit_time_s = (drop.centre_m.z - surface_m(drop.centre_m.xy)) / length(velocity_m_s.xyz);
  return drop;
}
