// Where a drop's way first meets a surface: first_hit of raytrace/drop_step.h, in float, from the
// low corner of the rain's box.
layout(std430, binding = TOP_HEIGHTS) readonly buffer TopHeights { float top_heights[]; };

const float nowhere = 1e30;
const float no_surface_m = -1e30;

struct Hit {
  float share;  // of the way; nowhere: it meets none
  vec3 normal;
};

// Texel of a cell of the grid: height from the box's low corner, slopes; z: no_surface_m for none.
vec3 texel_of(ivec2 cell) {
  if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, top_layout.xy)))
    return vec3(0, 0, no_surface_m);
  int first = 3 * (cell.y * top_layout.x + cell.x);
  return vec3(top_heights[first + 1], top_heights[first + 2], top_heights[first] + top_grid.w);
}

float height_over(vec3 texel, vec2 beside_px) {
  return texel.z + dot(texel.xy, beside_px - 0.5) * top_grid.z;
}

bool is_below(vec3 place_m) {
  vec2 px = (place_m.xy - top_grid.xy) / top_grid.z;
  return place_m.z <= height_over(texel_of(ivec2(floor(px))), px - floor(px));
}

Hit hit_in_cell(vec3 from_m, vec3 way_m, vec2 from_px, vec2 way_px, ivec2 cell, int crossed,
                float begin, float end) {
  vec3 texel = texel_of(cell);
  if (texel.z <= 0.5 * no_surface_m) return Hit(nowhere, vec3(0));
  float first_m = from_m.z + begin * way_m.z -
                  height_over(texel, from_px + begin * way_px - vec2(cell));
  float last_m = from_m.z + end * way_m.z - height_over(texel, from_px + end * way_px - vec2(cell));
  vec3 upward = normalize(vec3(-texel.xy, 1));
  if (first_m < -top_grid.z && crossed >= 0) {
    vec3 normal = vec3(0);
    normal[crossed] = way_px[crossed] > 0.0 ? -1.0 : 1.0;
    return Hit(begin, normal);
  }
  if (first_m <= 0.0) return Hit(begin, upward);
  if (last_m > 0.0) return Hit(nowhere, vec3(0));
  return Hit(begin + (end - begin) * first_m / (first_m - last_m), upward);
}

Hit first_hit(vec3 from_m, vec3 way_m) {
  vec2 from_px = (from_m.xy - top_grid.xy) / top_grid.z, way_px = way_m.xy / top_grid.z;
  ivec2 cell = ivec2(floor(from_px));
  int crossed = -1;
  float begin = 0.0;
  // No more borders than the way has: far from the grid's corner a float may not tell two apart.
  int borders = int(min(abs(way_px.x) + abs(way_px.y), 1e6)) + 3;
  for (int i = 0; i < borders && begin < 1.0; ++i) {
    vec2 leaves = vec2(nowhere);
    for (int axis = 0; axis < 2; ++axis) {
      float border = float(cell[axis]) + (way_px[axis] > 0.0 ? 1.0 : 0.0);
      if (way_px[axis] != 0.0) leaves[axis] = (border - from_px[axis]) / way_px[axis];
    }
    float end = max(begin, min(min(leaves.x, leaves.y), 1.0));
    Hit hit = hit_in_cell(from_m, way_m, from_px, way_px, cell, crossed, begin, end);
    if (hit.share < nowhere) return hit;
    crossed = leaves.x < leaves.y ? 0 : 1;
    cell[crossed] += way_px[crossed] > 0.0 ? 1 : -1;
    begin = end;
  }
  return Hit(nowhere, vec3(0));
}
