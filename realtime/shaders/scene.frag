#version 450 core
// Lambert: L = emission + albedo (ambient + sum_lights I / r^2 cos / pi), in cd/m^2.
#include "scene_uniforms.glsl"

struct Material {
  vec4 base_color;
  vec4 emission_cd_m2;
};
struct Light {
  vec4 position_m;  // from the camera
  vec4 intensity_cd;
};
layout(std430, binding = MATERIALS) readonly buffer Materials { Material materials[]; };
layout(std430, binding = TRIANGLE_MATERIAL) readonly buffer Triangles { uint triangle_material[]; };
layout(std430, binding = LIGHTS) readonly buffer Lights { Light lights[]; };

in vec3 surface_place_m;
in vec3 surface_normal;
layout(location = 0) out vec4 radiance;

const float pi = 3.14159265358979;

void main() {
  Material material = materials[triangle_material[gl_PrimitiveID]];
  vec3 normal = normalize(surface_normal);
  vec3 irradiance = pi * ambient.rgb;
  for (int i = 0; i < int(sky.w); ++i) {
    vec3 to_light = lights[i].position_m.xyz - surface_place_m;
    float squared_m2 = dot(to_light, to_light);
    // A lamp may touch a surface: there its irradiance has no bound; within 1 mm it stays the same.
    float distance_m = sqrt(max(squared_m2, 1e-6));
    float cosine = max(dot(normal, to_light) / distance_m, 0.0);
    irradiance += lights[i].intensity_cd.rgb * cosine / (distance_m * distance_m);
  }
  radiance = vec4(material.base_color.rgb / pi * irradiance + material.emission_cd_m2.rgb, 1);
}
