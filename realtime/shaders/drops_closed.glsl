// Drops as a function of seed and time: the closed form of raytrace/rain_space.h.
#if DENSITY
layout(std430, binding = DENSITIES) readonly buffer Densities { float densities[]; };
#endif

vec3 velocity_of(Drop drop) { return rain_sizes[drop.size].velocity_m_s.xyz; }
vec3 against_fall(Drop drop) { return rain_sizes[drop.size].axis_z.xyz; }

#if DENSITY
// The share of the rain that falls there.
float density_share(vec2 texel) {
  ivec2 at = ivec2(floor(texel));
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, density.xy))) return 0.0;
  return densities[at.y * density.x + at.x];
}
#endif

// False where there is no such drop, or it is outside the rain's box.
bool drop_at(uint group_number, uint place_in_group, out Drop drop) {
  if (group_number >= uint(sizes.x)) return false;
  DropGroup group = drop_groups[group_number];
  if (place_in_group >= group.drops.w) return false;
  RainSize size = rain_sizes[group.what.x];
  uint item = group.drops.z + place_in_group, segments = size.run.z;
  uint k = item / segments;
  drop.size = group.what.x;
  drop.segment = int(item - k * segments);
  drop.counts_for = group.corner_m.w * clamp(group.corner_top.w - float(k), 0.0, 1.0);
  vec3 moved = vec3(0);  // in the frame
  drop.layer = group.what.y;
  if (group.what.y < 0) {
    uint start = rain_hash(uvec3(group.drops.x, k, 0u)).x;
    uint up = start - size.run.x;
    uint round_number = size.run.y + (start < size.run.x ? 1u : 0u);
    uvec3 place = rain_hash(uvec3(group.drops.y, k, round_number));
    moved = vec3(size.axis_x.w * fraction(place.x), size.axis_x.w * fraction(place.y),
                 size.axis_y.w * fraction(up));
#if DENSITY
    vec2 texel = group.corner_density.xy + moved.x * size.density_axes.xy +
                 moved.y * size.density_axes.zw;
    uvec3 thin = rain_hash(uvec3(uint(group.what.z), k, round_number));
    if (!(fraction(thin.x) < density_share(texel))) return false;
#endif
    uint set, low;
    umulExtended(place.z, uint(counts.x), set, low);
    drop.layer = int(set);
  }
  drop.centre_m = group.corner_m.xyz + moved.x * size.axis_x.xyz + moved.y * size.axis_y.xyz +
                  moved.z * size.axis_z.xyz;
  vec3 in_frame = group.corner_top.xyz + moved;
  drop.hit_time_s = (in_frame.z - surface_m(size, in_frame.xy)) / size.times.w;
  return group.what.y >= 0 || (all(greaterThanEqual(drop.centre_m, box_min_m.xyz)) &&
                               all(lessThanEqual(drop.centre_m, box_max_m.xyz)));
}
