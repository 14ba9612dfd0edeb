#version 450 core
// A linear picture as write_png shows it (atlas/image_io.h): divided by white, cut to 0..1, sRGB
// (IEC 61966-2-1). Row 0 of the picture is at the top of the target, whose rows count from below.
layout(binding = PICTURE) uniform sampler2D picture;
layout(location = 0) uniform float white;
layout(location = 1) uniform ivec2 target_px;
layout(location = 0) out vec4 shown;

void main() {
  vec2 from_top = vec2(gl_FragCoord.x, float(target_px.y) - gl_FragCoord.y) / vec2(target_px);
  ivec2 size = textureSize(picture, 0);
  vec3 radiance = texelFetch(picture, min(ivec2(from_top * vec2(size)), size - 1), 0).rgb;
  vec3 linear = clamp(radiance / white, 0.0, 1.0);
  vec3 curved = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  shown = vec4(mix(curved, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1);
}
