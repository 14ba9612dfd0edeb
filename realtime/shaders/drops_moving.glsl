// Drops that are moved by steps: drop_now of raytrace/drop_motion.h, in float. Of their groups
// (DropGroup): corner_m, corner_top of the box's low corner; drops: place of the size's first drop,
// key of its bits, then as ever. box_min_m.w: seconds since the last step.
#include "wind_drops.glsl"

vec3 velocity_of(Drop drop) { return drop.velocity_m_s; }
vec3 against_fall(Drop drop) { return -normalize(drop.velocity_m_s); }

void set_hit(RainSize size, vec3 in_frame, inout Drop drop) {
  float above_m = in_frame.z - surface_m(size, in_frame.xy);
  float fall_m_s = -drop.velocity_m_s.z;
  bool falls = above_m <= 0.0 || fall_m_s >= LEAST_SPEED_M_S;
  drop.hit_time_s = falls ? above_m / max(fall_m_s, LEAST_SPEED_M_S) : 1e30;
}

// A single drop's closed form: straight on.
void set_single(DropGroup group, RainSize size, inout Drop drop) {
  drop.layer = group.what.y;
  drop.velocity_m_s = size.velocity_m_s.xyz;
  drop.centre_m = group.corner_m.xyz;
  drop.hit_time_s =
      (group.corner_top.z - surface_m(size, group.corner_top.xy)) / size.times.w;
}

bool drop_at(uint group_number, uint place_in_group, out Drop drop) {
  if (group_number >= uint(sizes.x)) return false;
  DropGroup group = drop_groups[group_number];
  if (place_in_group >= group.drops.w) return false;
  RainSize size = rain_sizes[group.what.x];
  uint item = group.drops.z + place_in_group, segments = size.run.z;
  uint k = item / segments;
  drop.size = group.what.x;
  drop.segment = int(item - k * segments);
  drop.counts_for = 1.0;
  if (group.what.y >= 0) {
    set_single(group, size, drop);
    return true;
  }
  MovingDrop moved = moving_drops[group.drops.x + k];
  uint set, low;
  umulExtended(rain_hash(uvec3(group.drops.y, k, moved.fall)).x, uint(counts.x), set, low);
  drop.layer = int(set);
  drop.velocity_m_s = moved.velocity_m_s;
  if (length(drop.velocity_m_s) < LEAST_SPEED_M_S) drop.velocity_m_s = vec3(0, 0, -LEAST_SPEED_M_S);
  float late_s = box_min_m.w + max(moved.since_hit_s, 0.0);
  vec3 moved_m = moved.position_m + late_s * drop.velocity_m_s;
  drop.centre_m = group.corner_m.xyz + moved_m;
  if (moved.since_hit_s >= 0.0)
    drop.hit_time_s = -late_s;
  else
    set_hit(size, group.corner_top.xyz + moved_m, drop);
  return true;
}
