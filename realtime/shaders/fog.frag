#version 450 core
// Mist and undrawn rain over the scene: rgb is added, what lies below counts alpha. The formulas of
// raytrace/rain_fog.h; with GLOW, also the light that the medium scatters from lamps and suns,
//   int sigma(s) E(s) p(angle) exp(-tau(s) - everywhere d(s)) ds
// of a lamp by samples at equal angles seen from it (Kulla and Fajardo 2012), where E is even, warped
// by the half-angle formula that evens out most of the phase function's peak; of a sun at equal steps
// of what the air everywhere leaves.
#include "fog_uniforms.glsl"
#if GLOW
#include "lights.glsl"
#include "shadows.glsl"
#endif

layout(binding = SURFACE_DEPTH) uniform sampler2D surface_depth;
layout(location = 0) out vec4 veil;

const float pi = 3.14159265358979;
const float far_m = 1e6;

struct Stretch {
  float from, to;
};

void clip_stretch(float slope, float low, float high, inout Stretch stretch) {
  if (abs(slope) < 1e-12) {
    if (low > 0.0 || high < 0.0) stretch.to = -1.0;
    return;
  }
  stretch.from = max(stretch.from, min(low / slope, high / slope));
  stretch.to = min(stretch.to, max(low / slope, high / slope));
}

Stretch in_box(vec3 direction) {
  Stretch box = Stretch(0.0, far_m);
  for (int axis = 0; axis < 3; ++axis)
    clip_stretch(direction[axis], fog_box_min_m[axis], fog_box_max_m[axis], box);
  return box;
}

float local_end(int i, vec3 direction) {
  float along = dot(direction, fog_slabs[i].xyz);
  float across = length(direction - along * fog_slabs[i].xyz);
  Stretch local = Stretch(0.0, far_m);
  clip_stretch(along, fog_extents[i].x, fog_extents[i].y, local);
  if (across > 0.0) local.to = min(local.to, fog_air.y / across);
  return max(0.0, local.to);
}

// Of the ray: where each slab's undrawn rain begins, and where all of it ends.
struct Medium {
  float from[MOST_SLABS];
  float to;
};

Medium medium_along(vec3 direction) {
  Medium medium;
  Stretch box = in_box(direction);
  medium.to = box.to;
  for (int i = 0; i < fog_counts.x; ++i)
    medium.from[i] = max(box.from, local_end(i, direction));
  return medium;
}

float depth_to(Medium medium, float distance_m) {
  float depth = fog_air.x * distance_m;
  for (int i = 0; i < fog_counts.x; ++i)
    depth += fog_slabs[i].w * max(0.0, min(medium.to, distance_m) - medium.from[i]);
  return depth;
}

#if GLOW
float density_at(Medium medium, float s) {
  float density = fog_air.x;
  for (int i = 0; i < fog_counts.x; ++i)
    density += s > medium.from[i] && s < medium.to ? fog_slabs[i].w : 0.0;
  return density;
}

// Henyey and Greenstein 1941.
float phase(float cosine) {
  float g = fog_air.z, base = 1.0 + g * g - 2.0 * g * cosine;
  return (1.0 - g * g) / (4.0 * pi * base * sqrt(base));
}

vec3 scattered(Medium medium, vec3 direction, float s, Illumination lit, Light light) {
  float beyond_m = light.place.w == 0.0 ? 0.0 : lit.distance_m;
  float left = exp(-depth_to(medium, s) - fog_air.x * beyond_m);
  float share = lit_share(light, s * direction + fog_camera_m.xyz, lit.toward);
  return density_at(medium, s) * phase(dot(lit.toward, direction)) * left * share * lit.lux;
}

vec3 sun_glow(Medium medium, vec3 direction, float end_m, Light light) {
  vec3 sum = vec3(0);
  float taken = 1.0 - exp(-fog_air.x * end_m);
  for (int k = 0; k < GLOW_SAMPLES; ++k) {
    float u = (float(k) + 0.5) / GLOW_SAMPLES;
    float s = taken > 1e-3 ? -log(1.0 - u * taken) / fog_air.x : u * end_m;
    float ds = taken > 1e-3 ? taken / (fog_air.x * (1.0 - u * taken)) : end_m;
    sum += ds / GLOW_SAMPLES *
           scattered(medium, direction, s, illumination(light, s * direction), light);
  }
  return sum;
}

// The angle of scattering runs from that at the camera to that at the end of the ray.
vec3 lamp_glow(Medium medium, vec3 direction, float end_m, Light light) {
  float foot_m = dot(light.place.xyz, direction);
  float beside_m = max(length(light.place.xyz - foot_m * direction), max(light.intensity.w, 1e-3));
  float narrow = (1.0 - fog_air.z) / (1.0 + fog_air.z);
  float first = 2.0 * atan(tan(0.5 * atan(beside_m, foot_m)) / narrow);
  float last = 2.0 * atan(tan(0.5 * atan(beside_m, foot_m - end_m)) / narrow);
  float step = (last - first) / GLOW_SAMPLES;
  vec3 sum = vec3(0);
  for (int k = 0; k < GLOW_SAMPLES; ++k) {
    float half_tangent = tan(0.5 * (first + (float(k) + 0.5) * step));
    float tangent = narrow * half_tangent;  // of half the angle of scattering
    float angle = 2.0 * atan(tangent);
    float slope = narrow * (1.0 + half_tangent * half_tangent) / (1.0 + tangent * tangent);
    float s = foot_m - beside_m / tan(angle);
    float ds = beside_m / (sin(angle) * sin(angle)) * slope * step;
    sum += ds * scattered(medium, direction, s, illumination(light, s * direction), light);
  }
  return sum;
}

vec3 glow(Medium medium, vec3 direction, float distance_m) {
  vec3 sum = vec3(0);
  float end_m = min(distance_m, fog_air.w);
  for (int i = 0; i < fog_counts.y; ++i) {
    Light light = lights[i];
    sum += light.place.w == 0.0 ? sun_glow(medium, direction, end_m, light)
                                : lamp_glow(medium, direction, end_m, light);
  }
  return sum;
}
#endif

void main() {
  float depth = texelFetch(surface_depth, ivec2(gl_FragCoord.xy), 0).r;
  vec2 size = vec2(fog_camera_up.w, fog_camera_forward.w);
  vec2 px = gl_FragCoord.xy / SUBPIXELS - 0.5 * size;
  vec3 ray = fog_camera_right.w * fog_camera_forward.xyz + px.x * fog_camera_right.xyz -
             px.y * fog_camera_up.xyz;
  vec3 direction = normalize(ray);
  float distance_m = depth > 0.0
      ? min(far_m, NEAR_M / depth / dot(direction, fog_camera_forward.xyz)) : far_m;
  Medium medium = medium_along(direction);
  float left = exp(-depth_to(medium, distance_m));
  veil = vec4(fog_environment.rgb * (1.0 - left), left);
#if GLOW
  veil.rgb += glow(medium, direction, distance_m);
#endif
}
