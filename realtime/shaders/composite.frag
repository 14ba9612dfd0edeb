#version 450 core
// C = T B + S, with B the mean of the pixel's SUBPIXELS x SUBPIXELS samples, T = exp(-sum tau) what
// all streaks together let through, and S their light as seen past each other.
//
// Streaks are added in any order, so which hides which is unknown. In the mean, a streak has
// exp(-sigma d) of the rain before it, d its depth beyond where the rain begins: each is added with
// that weight, and the sum is scaled so that what covers the pixel is what hides it:
//   S = sum(w S_i) (1 - T) / sum(w c_i)
// For one streak that is S_i exactly; for many faint ones the sum of all.
layout(binding = SCENE_COLOR) uniform sampler2D scene_color;
#if WITH_RAIN
layout(binding = RAIN) uniform sampler2D rain_sum;
layout(binding = COVERAGE) uniform sampler2D coverage_sum;
layout(location = 2) out vec4 rain;  // a: tau of all streaks
#endif
#if WITH_SPLAT
layout(std430, binding = SPLAT_SUMS) readonly buffer SplatSums {
  int splat_sums[];  // rain_splat.comp
};
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
  vec4 streaks = texelFetch(rain_sum, px, 0);
  float coverage = texelFetch(coverage_sum, px, 0).r;
#if WITH_SPLAT
  int first = 5 * (px.y * textureSize(rain_sum, 0).x + px.x);
  ivec3 light = ivec3(splat_sums[first], splat_sums[first + 1], splat_sums[first + 2]);
  streaks.rgb += RADIANCE_QUANTUM * vec3(light);
  streaks.a += SHARE_QUANTUM * float(splat_sums[first + 3]);
  coverage += SHARE_QUANTUM * float(splat_sums[first + 4]);
#endif
  rain = vec4(0);
  // A dry pixel keeps its bits.
  float tau = streaks.a;
  if (coverage > 0.0) {
    // 1 - exp(-tau) without its cancellation.
    float hidden = tau < 0.01 ? tau * (1.0 - tau * (0.5 - tau / 6.0)) : 1.0 - exp(-tau);
    rain = vec4(streaks.rgb * (hidden / coverage), tau);
    color = vec4((1.0 - hidden) * background.rgb + rain.rgb, 1);
  }
#endif
}
