#version 450 core
// A picture that is given, with its depth: SUBPIXELS x SUBPIXELS alike for each of its pixels.
layout(binding = PICTURE_COLOR) uniform sampler2D picture_color;
layout(binding = PICTURE_DEPTH) uniform sampler2D picture_depth;
#if DEPTH_ALONE
layout(location = 0) out float depth_m;
#else
layout(location = 0) out vec4 radiance;
#endif

void main() {
  ivec2 px = ivec2(gl_FragCoord.xy) / SUBPIXELS;
  float along_m = texelFetch(picture_depth, px, 0).r;
#if DEPTH_ALONE
  depth_m = along_m;
#else
  radiance = vec4(texelFetch(picture_color, px, 0).rgb, 1);
#endif
  gl_FragDepth = isinf(along_m) ? 0.0 : NEAR_M / along_m;
}
