#version 450 core
// How many streaks of each group of drops the picture shows.
#include "rain_group.glsl"
#include "rain_placement.glsl"
#include "rain_rank.glsl"

layout(local_size_x = GROUP_SIZE) in;
layout(std430, binding = GROUP_STARTS) writeonly buffer GroupCounts { uint group_counts[]; };

void main() {
  Drop drop;
  Placement placed;
  bool visible = drop_at(drop_group_index(), place_in_drop_group(), drop) &&
                 place_streak(drop, placed) && in_picture(placed);
  uint total;
  rank_in_group(visible, total);
  if (gl_LocalInvocationID.x == 0u && drop_group_index() < uint(sizes.x))
    group_counts[group_index()] = total;
}
