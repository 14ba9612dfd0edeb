#version 450 core
// A textured quad for each streak, as Creus (2010) draws them: from the drop's place to where it is
// when the shutter closes, as wide as a cell of the atlas, facing the eye; lit by the nearest light
// of the atlas for each light of the scene, between its two neighbouring views.
#include "rain_light.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;
flat in int drop_index[];

flat out ivec2 view;
flat out vec2 view_weight;
flat out vec3 rows;  // of the path on screen; the last that is drawn; transmitted by fog
flat out int layer;
flat out vec3 lux[BILLBOARD_LIGHTS];
flat out uint cells[BILLBOARD_LIGHTS];
out vec2 place;  // across the cell, and row

vec3 kept_lux[BILLBOARD_LIGHTS];
uint kept_cells[BILLBOARD_LIGHTS];

void keep_lit(uint at, vec3 value, uint cell) {
  kept_lux[at] = value;
  kept_cells[at] = cell;
}

void put_corner(Placement placed, vec2 corner, Drop drop, ivec2 views, vec2 weights, float transmitted) {
  float end = end_row(placed.path_rows, placed.clip_row);
  vec2 at = corner * vec2(cell.y, end);
  vec2 px = placed.origin_px + at.x * placed.column_px + at.y * placed.row_px;
  gl_Position = vec4(2.0 * px / vec2(camera_up.w, camera_forward.w) - 1.0, NEAR_M / placed.depth_m, 1);
  place = vec2(corner.x, at.y);
  rows = vec3(placed.path_rows, end, transmitted);
  layer = drop.layer;
  view = views;
  view_weight = weights;
  for (int i = 0; i < counts.y; ++i) {
    lux[i] = kept_lux[i];
    cells[i] = kept_cells[i];
  }
  EmitVertex();
}

void main() {
  Drop drop;
  Placement placed;
  uint index = uint(drop_index[0]);
  if (!(drop_at(index / DROPS_OF_GROUP, index % DROPS_OF_GROUP, drop) && place_streak(drop, placed) &&
        in_picture(placed)))
    return;
  float transmitted = exp(-air.x * length(placed.middle_m));
  for (int i = 0; i < counts.y; ++i)
    keep_light(uint(i), lights[i], drop, placed, transmitted);
  ivec2 views;
  vec2 weights;
  streak_views(drop, view_elevation_deg(placed), views, weights);
  put_corner(placed, vec2(0, 0), drop, views, weights, transmitted);
  put_corner(placed, vec2(1, 0), drop, views, weights, transmitted);
  put_corner(placed, vec2(0, 1), drop, views, weights, transmitted);
  put_corner(placed, vec2(1, 1), drop, views, weights, transmitted);
  EndPrimitive();
}
