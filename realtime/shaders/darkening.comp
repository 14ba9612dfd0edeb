#version 450 core
// Wang, Lin, Fang, Wei and Guo (MSR-TR-2006-102) darken a scene toward its luminance; the brightness
// is ours.
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;
layout(rgba32f, binding = COLOR) uniform image2D color;

void main() {
  ivec2 px = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(px, imageSize(color)))) return;
  vec3 radiance = imageLoad(color, px).rgb;
  vec3 grey = vec3(dot(radiance, LUMINANCE));
  imageStore(color, px, vec4(BRIGHTNESS * mix(radiance, grey, DESATURATION), 1));
}
