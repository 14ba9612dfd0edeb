#version 450 core
// Lambert: L = emission + albedo (ambient + sum_lights E cos / pi), E without what surfaces
// in between take, in cd/m^2.
#include "lights.glsl"
#include "scene_uniforms.glsl"
#include "shadows.glsl"

struct Material {
  vec4 base_color;
  vec4 emission_cd_m2;
};
layout(std430, binding = MATERIALS) readonly buffer Materials { Material materials[]; };
layout(std430, binding = TRIANGLE_MATERIAL) readonly buffer Triangles { uint triangle_material[]; };

in vec3 surface_place_m;
in vec3 surface_normal;
layout(location = 0) out vec4 radiance;

const float pi = 3.14159265358979;

void main() {
  Material material = materials[triangle_material[gl_PrimitiveID]];
  vec3 normal = normalize(surface_normal);
  vec3 irradiance = pi * ambient.rgb;
  for (int i = 0; i < int(sky.w); ++i) {
    Illumination lit = illumination(lights[i], surface_place_m);
    float cosine = max(dot(normal, lit.toward), 0.0);
    if (cosine == 0.0) continue;
    // A surface does not shade itself: looked up two texels of the map above it.
    float texel_m = lights[i].more.w * (lights[i].place.w == 0.0 ? 1.0 : lit.distance_m);
    vec3 above_m = surface_place_m + (2.0 * texel_m + 0.005) * normal;
    irradiance += lit.lux * cosine * lit_share(lights[i], above_m + camera_m.xyz, lit.toward);
  }
  radiance = vec4(material.base_color.rgb / pi * irradiance + material.emission_cd_m2.rgb, 1);
}
