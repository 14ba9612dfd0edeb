// What every rain shader knows; mirrors RainUniforms of realtime/rain_pass.h. Positions are
// relative to the camera: a float then errs by 2^-24 of the distance to the drop, not to the origin
// of the world.
layout(std140, binding = RAIN_UNIFORMS) uniform RainUniforms {
  vec4 camera_right;    // w: focal length in px
  vec4 camera_up;       // w: picture width in px
  vec4 camera_forward;  // w: picture height in px
  vec4 box_corner_m;    // x_min, y_min, z_max of the rain; w: pixel of the streak pictures
  vec4 box_size_m;      // w: exposure in s
  vec4 velocity_m_s;    // of all drops; w: mean radius in m
  vec4 top_grid_m;      // corner of the top height grid (x, y), its texel, its default height
  vec4 cell;            // path_top_row; cell width; widest texel in px; rows below the path
  vec4 environment;     // radiance in cd/m^2
  uvec4 fall;           // phase, round (FallState); phase, place (RainSeeds)
  ivec4 counts;         // drops, lights of the scene, lights of the atlas, views
  ivec4 sizes;          // layers, finest level, coarsest level, streaks drawn
};
