#version 450 core
// The centres of all drops from the camera, three floats each: for the test against drop_field.
#include "rain_common.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = CENTRES) writeonly buffer Centres { float centres_m[]; };

void main() {
  uint k = gl_GlobalInvocationID.x;
  if (k >= uint(counts.x)) return;
  vec3 centre = drop_at(k).centre_m;
  for (int i = 0; i < 3; ++i) centres_m[3u * k + uint(i)] = centre[i];
}
