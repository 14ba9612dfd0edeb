#version 450 core
// One of the two steps of realtime/blur_pass.h: ROWS, from the means of pixels along rows; else along
// columns, back to all SUBPIXELS x SUBPIXELS of a pixel alike.
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;
layout(rgba32f, binding = COLOR) uniform image2D color;
layout(rgba32f, binding = ACROSS) uniform image2D across;
layout(std430, binding = WEIGHTS) readonly buffer Weights {
  float weights[];
};

#if ROWS
vec3 pixel(ivec2 px, int step, ivec2 size) {
  px.x = clamp(px.x + step, 0, size.x - 1);
  vec3 sum = vec3(0);
  for (int y = 0; y < SUBPIXELS; ++y) {
    for (int x = 0; x < SUBPIXELS; ++x)
      sum += imageLoad(color, SUBPIXELS * px + ivec2(x, y)).rgb;
  }
  return sum / float(SUBPIXELS * SUBPIXELS);
}
#else
vec3 pixel(ivec2 px, int step, ivec2 size) {
  px.y = clamp(px.y + step, 0, size.y - 1);
  return imageLoad(across, px).rgb;
}
#endif

void main() {
  ivec2 px = ivec2(gl_GlobalInvocationID.xy), size = imageSize(across);
  if (any(greaterThanEqual(px, size))) return;
  vec3 sum = weights[0] * pixel(px, 0, size);
  for (int i = 1; i <= REACH; ++i) sum += weights[i] * (pixel(px, i, size) + pixel(px, -i, size));
#if ROWS
  imageStore(across, px, vec4(sum, 1));
#else
  for (int y = 0; y < SUBPIXELS; ++y) {
    for (int x = 0; x < SUBPIXELS; ++x)
      imageStore(color, SUBPIXELS * px + ivec2(x, y), vec4(sum, 1));
  }
#endif
}
