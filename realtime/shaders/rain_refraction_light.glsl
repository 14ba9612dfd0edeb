// How a thin streak is lit that refracts (realtime/refraction_look.h): one radiance for all of it, the
// lamps as a sphere has them, the scene as a few lines of sight through the drop see it.
#include "rain_transfer.glsl"
#include "rain_refraction.glsl"

// Equal parts of the outline's area (a sunflower's seeds), each at another time of the picture.
vec3 surroundings_through(Drop drop, Placement placed, vec3 onward) {
  const int seeds = 24;
  int seen = seen_drop(drop.size, drop.layer, view_elevation_deg(placed));
  mat3 axes = mask_axes(onward, placed.frame);
  vec3 sum = vec3(0);
  float left_out = 0.0, area = 0.0;
  for (int i = 0; i < seeds; ++i) {
    float time = fract((float(i) + 0.5) * 0.618033988749895), turn = float(i) * 2.399963229728653;
    vec2 toward = vec2(cos(turn), sin(turn));
    time *= mask_sizes[drop.size].y;
    float outline = outline_toward(toward, seen, time);
    float share = outline * outline, rest = 1.0;
    vec2 q = place_in_mask(sqrt((float(i) + 0.5) / float(seeds)) * toward, 1.0);
    for (int order = 0; order < MASK_ORDERS; ++order) {
      vec4 exit = mask_exit(seen, time, order, q);
      vec3 own = normalize(exit.xyz);
      float spread = spread_of(inversesqrt(float(seeds) / 3.14159265358979), impact_of(q), order,
                               length(own.xy));
      sum += share * exit.w * surroundings_toward(axes * own, spread);
      rest -= exit.w;
    }
    left_out += share * rest;
    area += share;
  }
  return (sum + left_out * mean_surroundings()) / area;
}

// In cd/m^2, behind the fog that lies before the streak.
vec3 streak_radiance(Drop drop, Placement placed) {
  vec3 onward = normalize(placed.middle_m);
  vec3 sum = surroundings_through(drop, placed, onward);
#if LOOK_LIGHTS
  sum += light_through(drop, placed, onward);
#endif
  return exp(-air.x * length(placed.middle_m)) * sum;
}
