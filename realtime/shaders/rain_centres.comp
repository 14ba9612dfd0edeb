#version 450 core
// Where the drops are that the rain has at shutter-open, in order of their groups: for the test
// against drop_field. w: 1 for a drop, 0 for none and for later segments of one.
#include "rain_drops.glsl"
#include "rain_group.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = CENTRES) writeonly buffer Centres { vec4 centres_m[]; };

void main() {
  if (drop_group_index() >= uint(sizes.x)) return;
  Drop drop;
  bool is_there = drop_at(drop_group_index(), place_in_drop_group(), drop) && drop.segment == 0;
  centres_m[group_index() * GROUP_SIZE + gl_LocalInvocationID.x] =
      is_there ? vec4(drop.centre_m, 1) : vec4(0);
}
