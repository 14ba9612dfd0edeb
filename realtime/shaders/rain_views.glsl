// Which views of the atlas a streak mixes: the rule of atlas/atlas_lookup.h.
#include "rain_placement.glsl"

layout(std430, binding = ATLAS_VIEWS) readonly buffer AtlasViews { vec4 atlas_views[]; };  // x: deg

const float degrees_per_radian = 57.29577951308232;

// Views from below, where the atlas has none of its own, are served by those from above.
bool flips_views_below() {
  return atlas_views[0].x >= 0.0;
}

void choose_views(float elevation_deg, out ivec2 view, out vec2 weight) {
  int above = 0;
  while (above < counts.w && atlas_views[above].x <= elevation_deg) ++above;
  view = ivec2(clamp(above - 1, 0, counts.w - 1), clamp(above, 0, counts.w - 1));
  weight = vec2(1, 0);
  if (above == 0 || above == counts.w) return;
  float low = atlas_views[view.x].x, high = atlas_views[view.y].x;
  weight.y = (elevation_deg - low) / (high - low);
#if VIEW_TAPS == 1
  weight.y = weight.y > 0.5 ? 1.0 : 0.0;
  if (weight.y == 1.0) view.x = view.y;
  weight = vec2(1, 0);
#else
  weight.x = 1.0 - weight.y;
#endif
}

float view_elevation_deg(Placement placed) {
  // atan: a driver's asin may err by 5e-4.
  return degrees_per_radian * atan(placed.frame.sin_view, placed.frame.cos_view);
}

// The views that a streak mixes; weights with what the picture's values count.
void streak_views(Drop drop, float view_deg, out ivec2 view, out vec2 weight) {
  choose_views(flips_views_below() ? abs(view_deg) : view_deg, view, weight);
  weight *= rain_sizes[drop.size].times.z * drop.counts_for;
}
