// What every rain shader knows; mirrors RainUniforms and GpuRainSize of realtime/rain_inputs.h.
// Positions are relative to the camera: a float then errs by 2^-24 of the distance to the drop, not
// to the origin of the world.
layout(std140, binding = RAIN_UNIFORMS) uniform RainUniforms {
  vec4 camera_right;    // w: focal length in px
  vec4 camera_up;       // w: picture width in px
  vec4 camera_forward;  // w: picture height in px
  vec4 camera_m;        // from the origin of the shadow maps
  vec4 box_min_m;       // drops are drawn whose centre is inside. w: of drops that move by steps, the
                        // seconds since the last one
  vec4 box_max_m;
  vec4 cell;         // of the atlas: path_top_row; cell width; widest texel in px; rows below the path
  vec4 environment;  // radiance in cd/m^2, of a sky that is the same from everywhere
  vec4 air;          // extinction in 1/m where drops are drawn: of the fog, of the drops; depth where
                     // those begin
  ivec4 counts;      // oscillation sets; lights of the scene, of the atlas (0 where it is not looked up);
                     // views
  ivec4 sizes;       // groups of drops, finest level, coarsest level, streaks drawn
  vec4 splat;        // thin streaks: widest cell and longest path in px; quanta of 1 cd/m^2, of 1
  vec4 splat_most;     // illuminance in lux of the brightest streak; of the lens (rain_lens.glsl)
                       // f A / 2 in px m, 1 / s in 1/m
  ivec4 splat_levels;  // their profiles: the finest level's, how many
  ivec4 density;     // texels of the density map across and down; 0 for none
};

struct RainSize {     // drops of one size and velocity
  vec4 axis_x;        // of the fall's frame, in the world; w: cell size in m
  vec4 axis_y;        // w: local height in m
  vec4 axis_z;        // w: pixel of the streak pictures in m
  vec4 velocity_m_s;  // w: radius in m
  vec4 times;         // of a segment, of the exposure (s); their ratio; speed in m/s
  vec4 top_grid;      // corner of the top heights in x and y, texel; what lies outside the grid
  vec4 density_axes;  // texels of the density map for a metre of x, for one of y
  ivec4 top_layout;   // first height, texels along x, along y
  uvec4 run;          // phase, round, segments
};
layout(std430, binding = RAIN_SIZES) readonly buffer RainSizes { RainSize rain_sizes[]; };
