// What a light does to a point: the formulas of raytrace/light.h. Mirrors GpuLight of
// realtime/gpu_scene.h.
struct Light {
  vec4 place;      // position from the camera, or the direction toward the sun; w: 0 for the sun
  vec4 intensity;  // cd, or lux of the sun; w: the lamp's radius in m
  vec4 axis;       // of a spot, the way its light goes; w: cosine of the outer half-angle
  vec4 more;       // 1 / (cosine of the inner half-angle - outer); first shadow map, or -1; how
};                 // many; their texel, in m for the sun, else in m at 1 m from the light
layout(std430, binding = LIGHTS) readonly buffer Lights { Light lights[]; };

struct Illumination {
  vec3 toward;
  float distance_m;
  vec3 lux;
};

Illumination illumination(Light light, vec3 at_m) {
  if (light.place.w == 0.0) return Illumination(light.place.xyz, 1e30, light.intensity.rgb);
  vec3 to_light = light.place.xyz - at_m;
  float distance_m = length(to_light);
  vec3 toward = distance_m > 0.0 ? to_light / distance_m : vec3(0, 0, 1);
  float near_m = max(distance_m, max(light.intensity.w, 1e-3));
  float t = clamp((-dot(toward, light.axis.xyz) - light.axis.w) * light.more.x, 0.0, 1.0);
  return Illumination(toward, distance_m, light.intensity.rgb / (near_m * near_m) * (t * t));
}
