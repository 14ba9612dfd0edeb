#version 450 core
// A quad around each streak, wide enough for every pixel that the streak touches.
#include "rain_placement.glsl"
#include "rain_streaks.glsl"

layout(std430, binding = STREAKS) readonly buffer Streaks { Streak streaks[]; };
flat out int streak_index;

void main() {
  streak_index = gl_InstanceID * QUADS_PER_INSTANCE + gl_VertexID / 4;
  gl_Position = vec4(2, 2, 2, 1);
  if (streak_index >= sizes.w) return;
  Streak streak = streaks[streak_index];
  if (streak.depth_m == no_streak) return;
  vec2 column = streak.column_px, row = streak.row_px;
  // A touched pixel's centre is within half a diagonal (0.7071 px); the rasteriser snaps corners to
  // 1/256 px or finer.
  float margin_px = 0.72;
#if LENS
  margin_px += circle_reach_px(streak.depth_m);
#endif
  vec2 margin = margin_px / abs(column.x * row.y - column.y * row.x) *
                vec2(length(row), length(column));
  float end = last_row(streak.path_rows, streak.clip_row);
  vec2 corner = vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1);
  vec2 place = mix(-margin, vec2(cell.y, end) + margin, corner);
  vec2 px = streak.origin_px + place.x * column + place.y * row;
  // Row 0 of the target is the picture's top, so y runs down in normalised coordinates too.
  vec2 ndc = 2.0 * px / vec2(camera_up.w, camera_forward.w) - 1.0;
  gl_Position = vec4(ndc, NEAR_M / streak.depth_m, 1);
}
