// What the splashes' placing shader hands to the drawing ones; mirrors StrokeRecord of
// realtime/stroke_record.h. A droplet that moves while the shutter is open is a rectangle with the
// mean and the variance of the disc's path, along and across; out of focus, with the circle's too.
struct Stroke {
  vec2 centre_px, half_axis_px;  // of the rectangle; from its centre to its end
  float half_width_px;
  float area_px;                 // covered, in pixels, times the share of the exposure
  float inverse_depth;           // NEAR_M / depth, or no_stroke
  float weight;                  // by what hides it: composite.frag
  vec4 radiance;
};
const float no_stroke = 0.0;
