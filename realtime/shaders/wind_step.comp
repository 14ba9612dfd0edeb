#version 450 core
// Steps of drops in moving air: stepped of raytrace/drop_motion.h, in float, from the low corner of
// the rain's box. A thread moves one drop of a size.
layout(local_size_x = GROUP_SIZE) in;

#include "rain_hash.glsl"
#include "rain_group.glsl"
#include "wind_drops.glsl"

layout(std140, binding = WIND_UNIFORMS) uniform WindUniforms {
  vec4 size_m;       // of the box; w: restitution
  vec4 node_step_m;  // of the wind's grid; w: nodes along an axis
  vec4 top_grid;     // corner of the top heights in x and y, texel; height of their lowest
  ivec4 top_layout;  // texels along x, along y
};
struct MovingSize {
  vec4 fall_m_s;  // in still air; w: its speed
  uvec4 drops;    // first two keys of the size, place of its first drop, number of drops
};
layout(std430, binding = MOVING_SIZES) readonly buffer MovingSizes { MovingSize moving_sizes[]; };
layout(std430, binding = WIND) readonly buffer Wind { vec4 wind_m_s[]; };
layout(location = 0) uniform uint size_index;
layout(location = 1) uniform uint steps;

#include "wind_way.glsl"

vec3 wind_at(vec3 place_m) {
  float last = node_step_m.w - 1.0;
  vec3 at = clamp(place_m / node_step_m.xyz, vec3(0), vec3(last));
  ivec3 first = min(ivec3(at), ivec3(int(last) - 1));
  vec3 share = at - vec3(first), sum = vec3(0);
  int n = int(node_step_m.w);
  for (int corner = 0; corner < 8; ++corner) {
    ivec3 up = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
    vec3 weight = mix(1.0 - share, share, vec3(up));
    ivec3 node = first + up;
    sum += weight.x * weight.y * weight.z * wind_m_s[(node.z * n + node.y) * n + node.x].xyz;
  }
  return sum;
}

// (1 - exp(-k t)) / k, by its series where the difference would lose its digits.
float faded_s(float k, float t_s) {
  float x = k * t_s;
  if (x < 0.03) return t_s * (1.0 - x * (1.0 / 2.0 - x * (1.0 / 6.0 - x / 24.0)));
  return (1.0 - exp(-x)) / k;
}

vec3 dragged(vec3 velocity_m_s, vec3 air_m_s, vec4 fall_m_s) {
  vec3 gravity = GRAVITY_M_S2 * fall_m_s.xyz / fall_m_s.w;
  float kappa = GRAVITY_M_S2 / (fall_m_s.w * fall_m_s.w);
  vec3 u = velocity_m_s - air_m_s;
  float s = length(u + 0.5 * STEP_S * gravity);
  float k = kappa * 2.0 * s / (1.0 + sqrt(1.0 + 2.0 * kappa * STEP_S * s));
  return velocity_m_s + faded_s(k, STEP_S) * (gravity - k * u);
}

MovingDrop fallen_again(uint k, MovingSize size, uint fall, float beyond_m) {
  uvec3 bits = rain_hash(uvec3(size.drops.x, k, fall));
  MovingDrop drop;
  drop.position_m = vec3(fraction(bits.x) * size_m.x, fraction(bits.y) * size_m.y,
                         size_m.z - mod(beyond_m, size_m.z));
  drop.velocity_m_s = size.fall_m_s.xyz + wind_at(drop.position_m);
  drop.since_hit_s = is_below(drop.position_m) ? 0.0 : -1.0;
  drop.fall = fall;
  return drop;
}

vec3 around_the_box(vec3 place_m) { return vec3(-floor(place_m.xy / size_m.xy) * size_m.xy, 0); }

MovingDrop met(MovingDrop drop, Hit hit, vec3 way_m) {
  float length_m = length(way_m);
  float back = length_m > 0.0 ? BACK_OFF_M / length_m : 0.0;
  drop.position_m += max(0.0, hit.share - back) * way_m;
  drop.position_m += around_the_box(drop.position_m);
  float inward_m_s = min(dot(drop.velocity_m_s, hit.normal), 0.0);
  vec3 off = drop.velocity_m_s - (1.0 + size_m.w) * inward_m_s * hit.normal;
  if (dot(off, hit.normal) > LEAST_BOUNCE_M_S)
    drop.velocity_m_s = off;
  else
    drop.since_hit_s = 0.0;
  return drop;
}

MovingDrop flown(MovingDrop drop, uint k, MovingSize size) {
  if (is_below(drop.position_m)) {  // a moving part has come
    drop.since_hit_s = 0.0;
    return drop;
  }
  vec3 before = drop.velocity_m_s, from_m = drop.position_m;
  drop.velocity_m_s = dragged(before, wind_at(from_m + 0.5 * STEP_S * before), size.fall_m_s);
  vec3 way = 0.5 * STEP_S * (before + drop.velocity_m_s);
  vec3 shift = around_the_box(from_m + way);
  for (int sides = 0; sides < 4; ++sides) {
    vec3 inside = vec3((sides & 1) != 0 ? shift.x : 0.0, (sides & 2) != 0 ? shift.y : 0.0, 0);
    if (sides > 0 && inside == vec3(0)) continue;
    Hit hit = first_hit(from_m + inside, way);
    if (hit.share < nowhere) {
      drop.position_m = from_m + inside;
      return met(drop, hit, way);
    }
  }
  drop.position_m = from_m + shift + way;
  float z_m = drop.position_m.z;
  if (z_m < 0.0) return fallen_again(k, size, drop.fall + 1u, -z_m);
  if (z_m > size_m.z) return fallen_again(k, size, drop.fall + 1u, z_m - size_m.z);
  if (is_below(drop.position_m)) drop.since_hit_s = 0.0;
  return drop;
}

MovingDrop stepped(MovingDrop drop, uint k, MovingSize size) {
  if (drop.since_hit_s < 0.0) return flown(drop, k, size);
  drop.since_hit_s += STEP_S;
  float beyond_m = -size.fall_m_s.z * drop.since_hit_s - drop.position_m.z;
  return beyond_m > 0.0 ? fallen_again(k, size, drop.fall + 1u, beyond_m) : drop;
}

void main() {
  MovingSize size = moving_sizes[size_index];
  uint k = group_index() * GROUP_SIZE + gl_LocalInvocationID.x;
  if (k >= size.drops.w) return;
  MovingDrop drop = moving_drops[size.drops.z + k];
  for (uint i = 0u; i < steps; ++i) drop = stepped(drop, k, size);
  moving_drops[size.drops.z + k] = drop;
}
