// Circles of a lens: raytrace/depth_of_field.h.
const float least_circle_px = LEAST_CIRCLE_PX;          // a smaller one is not seen
const float widest_walked_circle_px = WALKED_CIRCLE_PX;  // of a streak that is no quad

const float widest_defocused = 0.25;  // texel, in circles

float circle_px(float depth_m) { return splat_most.y * abs(splat_most.z - 1.0 / depth_m); }

// How far from a sharp streak its light may be: what rain_defocus.glsl makes of a circle is up to
// 1.1 of it wide, and two pixels more.
float circle_reach_px(float depth_m) {
  float circle = circle_px(depth_m);
  return circle > least_circle_px ? 1.1 * circle + 2.0 : 0.0;
}
