// Light of lamps and suns in a streak that is taken for a sphere: sum over them E D(angle).
#include "rain_views.glsl"

#if LOOK_LIGHTS
#include "rain_shade.glsl"

layout(std430, binding = TRANSFER) readonly buffer Transfer { float transfer_rings[]; };  // D, 1/sr

// transfer_at of raytrace/sphere_transfer.h.
float transfer_at(float angle) {
  const float last = float(TRANSFER_RINGS - 1);
  float at = clamp(angle * (float(TRANSFER_RINGS) / 3.14159265358979) - 0.5, 0.0, last);
  int low = int(at);
  return mix(transfer_rings[low], transfer_rings[min(low + 1, TRANSFER_RINGS - 1)], at - float(low));
}

vec3 light_through(Drop drop, Placement placed, vec3 onward) {
  RainSize size = rain_sizes[drop.size];
  vec3 path_m = size.times.x * velocity_of(drop);
  vec3 sum = vec3(0);
  for (int i = 0; i < counts.y; ++i) {
    Illumination lit = illumination(lights[i], placed.middle_m);
    // atan: a driver's acos is poor near 1, where the light shines through the drop.
    float angle = atan(length(cross(lit.toward, onward)), dot(lit.toward, onward));
    sum += path_lit_share(lights[i], placed.middle_m, path_m) * transfer_at(angle) * lit.lux;
  }
  return sum;
}
#endif
