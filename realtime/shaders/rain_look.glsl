// How a streak is lit that is not traced (realtime/rain_look.h): one radiance for all of it. As a
// sphere, raytrace/sphere_transfer.h:
//   sum over lights E D(angle) + sum_lm c_lm k_l Y_lm(from the eye to the drop)
#include "rain_transfer.glsl"

#if LOOK_HARMONICS > 0
layout(std430, binding = SKY) readonly buffer Sky { vec4 sky_seen[]; };  // c_lm k_l, cd/m^2

// raytrace/spherical_harmonics.h to degree 3.
vec3 sky_through(vec3 d) {
  float x = d.x, y = d.y, z = d.z;
  vec3 sum = 0.28209479177388 * sky_seen[0].rgb;
#if LOOK_HARMONICS > 1
  sum += 0.48860251190292 * (y * sky_seen[1].rgb + z * sky_seen[2].rgb + x * sky_seen[3].rgb);
#endif
#if LOOK_HARMONICS > 4
  sum += 1.09254843059208 * (x * y * sky_seen[4].rgb + y * z * sky_seen[5].rgb + x * z * sky_seen[7].rgb);
  sum += 0.31539156525252 * (3.0 * z * z - 1.0) * sky_seen[6].rgb;
  sum += 0.54627421529604 * (x * x - y * y) * sky_seen[8].rgb;
#endif
#if LOOK_HARMONICS > 9
  sum += 0.59004358992664 * (y * (3.0 * x * x - y * y) * sky_seen[9].rgb +
                             x * (x * x - 3.0 * y * y) * sky_seen[15].rgb);
  sum += 0.45704579946447 * (5.0 * z * z - 1.0) * (y * sky_seen[11].rgb + x * sky_seen[13].rgb);
  sum += 0.37317633259012 * z * (5.0 * z * z - 3.0) * sky_seen[12].rgb;
  sum += 1.44530572132028 * z * (2.0 * x * y * sky_seen[10].rgb + (x * x - y * y) * sky_seen[14].rgb);
#endif
  return max(sum, vec3(0));  // raytrace/sky_light.h
}
#endif

vec3 look_radiance(Drop drop, Placement placed) {
#if SPHERE
  vec3 onward = normalize(placed.middle_m);
  vec3 sum = vec3(0);
#if LOOK_LIGHTS
  sum += light_through(drop, placed, onward);
#endif
#if LOOK_HARMONICS > 0
  sum += sky_through(onward);
#endif
  return sum;
#else
  return vec3(STREAK_CD_M2);
#endif
}

// In cd/m^2, behind the fog that lies before the streak.
vec3 streak_radiance(Drop drop, Placement placed) {
  return exp(-air.x * length(placed.middle_m)) * look_radiance(drop, placed);
}
