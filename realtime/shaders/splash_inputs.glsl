// Mirrors SplashUniforms, GpuSplashSize and GpuSplashPart of realtime/splash_inputs.h: the tables
// of raytrace/splash.h.
layout(std140, binding = SPLASH_UNIFORMS) uniform SplashUniforms {
  vec4 fall_box_min_m;  // the rain's box, from the camera
  vec4 fall_box_max_m;
  vec4 splash_air;      // exposure in s; gravity in m/s^2
};

struct SplashSize {
  vec4 crown;   // life in s, height, first and last radius in m
  vec4 impact;  // Weber's number, its threshold, droplets a multiple of it, duration in s
  ivec4 parts;  // first, droplets of a variant
};
layout(std430, binding = SPLASH_SIZES) readonly buffer SplashSizes { SplashSize splash_sizes[]; };

struct SplashPart {
  vec4 first;     // place at launch in m; w: radius in m
  vec4 velocity;  // m/s; w: drag time in s, 0 for a bead
  vec4 more;      // delay in s; sum of the squared radii of its kind up to this one
};
layout(std430, binding = SPLASH_PARTS) readonly buffer SplashParts { SplashPart splash_parts[]; };
