#version 450 core
// C = exp(-tau) B + S, with B the mean of the pixel's SUBPIXELS x SUBPIXELS samples.
layout(binding = SCENE_COLOR) uniform sampler2D scene_color;
#if WITH_RAIN
layout(binding = RAIN) uniform sampler2D rain;
#endif
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 background;

void main() {
  ivec2 px = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0);
  for (int y = 0; y < SUBPIXELS; ++y) {
    for (int x = 0; x < SUBPIXELS; ++x)
      sum += texelFetch(scene_color, SUBPIXELS * px + ivec2(x, y), 0).rgb;
  }
  background = vec4(sum / float(SUBPIXELS * SUBPIXELS), 1);
  color = background;
#if WITH_RAIN
  vec4 streaks = texelFetch(rain, px, 0);
  // exp(-0) need not be 1 exactly on every driver, and a dry pixel keeps its bits.
  float transmitted = streaks.a == 0.0 ? 1.0 : exp(-streaks.a);
  color = vec4(transmitted * background.rgb + streaks.rgb, 1);
#endif
}
