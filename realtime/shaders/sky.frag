#version 450 core
// The environment where there is no surface: the mapping of atlas/image_io.h.
#include "scene_uniforms.glsl"

layout(binding = SKY_MAP) uniform sampler2D sky_map;
layout(location = 0) out vec4 radiance;

const float pi = 3.14159265358979;

void main() {
  vec2 size = vec2(camera_up.w, camera_forward.w);
  vec2 px = gl_FragCoord.xy / SUBPIXELS - 0.5 * size;
  vec3 direction = camera_right.w * camera_forward.xyz + px.x * camera_right.xyz -
                   px.y * camera_up.xyz;
  radiance = vec4(sky.rgb, 1);
  if (ambient.w == 0.0) return;
  // Azimuth from +x towards -y. At the poles atan(0, 0) is undefined, and any azimuth serves.
  float level = length(direction.xy);
  float azimuth = level > 0.0 ? atan(-direction.y, direction.x) : 0.0;
  float elevation = atan(direction.z, level);
  vec2 place = vec2(azimuth / (2.0 * pi) + 0.5, 0.5 - elevation / pi);
  radiance.rgb *= textureLod(sky_map, place, 0.0).rgb;
}
