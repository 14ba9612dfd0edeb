#version 450 core
// A quad around each stroke, wide enough for every pixel that the stroke touches.
#include "splash_strokes.glsl"

layout(std430, binding = STROKES) readonly buffer Strokes { Stroke strokes[]; };
layout(location = 0) uniform vec2 picture_px;
flat out int stroke_index;

const int corners[6] = int[6](0, 1, 2, 2, 1, 3);

void main() {
  stroke_index = gl_VertexID / 6;
  int corner = corners[gl_VertexID % 6];
  Stroke stroke = strokes[stroke_index];
  gl_Position = vec4(2, 2, 2, 1);
  if (stroke.inverse_depth == no_stroke) return;
  vec2 along = normalize(stroke.half_axis_px), across = vec2(-along.y, along.x);
  // A touched pixel's centre is within half a diagonal (0.7071 px); the rasteriser snaps corners to
  // 1/256 px or finer.
  vec2 reach_px = vec2(length(stroke.half_axis_px), stroke.half_width_px) + 0.72;
  vec2 side = vec2(corner & 1, corner >> 1) * 2.0 - 1.0;
  vec2 px = stroke.centre_px + side.x * reach_px.x * along + side.y * reach_px.y * across;
  gl_Position = vec4(2.0 * px / picture_px - 1.0, stroke.inverse_depth, 1);
}
