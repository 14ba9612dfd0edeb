#version 450 core
// How many drops of each group of GROUP_SIZE the picture shows.
#include "rain_placement.glsl"
#include "rain_rank.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = GROUP_STARTS) writeonly buffer GroupCounts { uint group_counts[]; };

void main() {
  uint k = gl_GlobalInvocationID.x;
  Placement placed;
  bool visible = k < uint(counts.x) && place_streak(drop_at(k), placed) && in_picture(placed);
  uint total;
  rank_in_group(visible, total);
  if (gl_LocalInvocationID.x == 0u) group_counts[gl_WorkGroupID.x] = total;
}
