#version 450 core
// The share of a stroke's area that lies in the pixel, exactly, times its radiance; summed as
// rain.frag sums streaks.
#include "rain_picture.glsl"
#include "splash_strokes.glsl"

layout(std430, binding = STROKES) readonly buffer Strokes { Stroke strokes[]; };
flat in int stroke_index;
layout(location = 0) out vec4 radiance_and_tau;
layout(location = 1) out float weighted_coverage;

// int clamp(x, 0, 1) dx
float clamped_integral(float x) {
  float inside = clamp(x, 0.0, 1.0);
  return 0.5 * inside * inside + max(x - 1.0, 0.0);
}

// int x dy along an edge, both cut to the unit square: summed around a polygon (Green) it is the
// area inside the square.
float edge_area(vec2 a, vec2 b) {
  vec2 y = clamp(vec2(a.y, b.y), 0.0, 1.0);
  if (y.x == y.y) return 0.0;
  vec2 x = a.x + (b.x - a.x) * clamp((y - a.y) / (b.y - a.y), 0.0, 1.0);
  float middle = 0.5 * (x.x + x.y), width = x.y - x.x;
  // Of so steep an edge the middle stands for all: 1e-3 px of it, squared, is lost.
  float mean = abs(width) < 1e-3
                   ? clamp(middle, 0.0, 1.0)
                   : (clamped_integral(x.y) - clamped_integral(x.x)) / width;
  return mean * (y.y - y.x);
}

float area_in_pixel(Stroke stroke, vec2 corner_px) {
  vec2 centre = stroke.centre_px - corner_px, axis = stroke.half_axis_px;
  vec2 side = stroke.half_width_px * normalize(vec2(-axis.y, axis.x));
  vec2 p0 = centre - axis - side, p1 = centre + axis - side;
  vec2 p2 = centre + axis + side, p3 = centre - axis + side;
  return edge_area(p0, p1) + edge_area(p1, p2) + edge_area(p2, p3) + edge_area(p3, p0);
}

void main() {
  Stroke stroke = strokes[stroke_index];
  float inside = max(area_in_pixel(stroke, gl_FragCoord.xy - 0.5), 0.0);  // rounds below
  float all = 4.0 * length(stroke.half_axis_px) * stroke.half_width_px;
  float coverage = min(stroke.area_px * inside / all, most_coverage);
  // Added up by the blender in the order of the strokes.
  radiance_and_tau = vec4(stroke.weight * coverage * stroke.radiance.rgb, optical_depth(coverage));
  weighted_coverage = stroke.weight * coverage;
}
