// How much of a light gets past the surfaces to a streak.
#include "rain_placement.glsl"
#include "shadows.glsl"

// The mean over the path, at the middles of its quarters.
float path_lit_share(Light light, vec3 middle_m, vec3 path_m) {
  if (light.more.y < 0.0) return 1.0;
  float sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    vec3 at_m = middle_m + (float(k) - 1.5) / 4.0 * path_m;
    Illumination lit = illumination(light, at_m);
    // Two texels toward the light: a surface that the drop is about to hit does not shade it.
    float texel_m = light.more.w * (light.place.w == 0.0 ? 1.0 : lit.distance_m);
    sum += lit_share(light, at_m + camera_m.xyz + 2.0 * texel_m * lit.toward, lit.toward);
  }
  return sum / 4.0;
}
