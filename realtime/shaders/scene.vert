#version 450 core
// A surface of the scene, seen from the camera. Reversed depth (1 at the near plane, 0 at
// infinity).
#include "scene_uniforms.glsl"

layout(location = 0) in vec3 placed_m;  // from scene_pass.h's origin
layout(location = 1) in vec3 normal;
out vec3 surface_place_m;  // from the camera
out vec3 surface_normal;
out float surface_depth_m;

void main() {
  vec3 position_m = placed_m - camera_m.xyz;
  surface_place_m = position_m;
  surface_normal = normal;
  surface_depth_m = dot(position_m, camera_forward.xyz);
  vec2 focal = 2.0 * camera_right.w / vec2(camera_up.w, camera_forward.w);
  // Row 0 of the target is the picture's top, so up is -y in normalised coordinates.
  vec2 xy = focal * vec2(dot(position_m, camera_right.xyz), -dot(position_m, camera_up.xyz));
  gl_Position = vec4(xy, NEAR_M, surface_depth_m);
}
