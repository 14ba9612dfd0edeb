#version 450 core
// A picture that is given, as another camera at the same place sees it: nothing where the picture's
// own camera does not look.
layout(binding = PICTURE_COLOR) uniform sampler2D picture_color;
layout(std140, binding = PICTURE_VIEWS) uniform PictureViews {
  vec4 picture_right, picture_up, picture_forward;  // GpuCamera: w is focal length, width, height
  vec4 view_right, view_up, view_forward;
};
layout(location = 0) out vec4 radiance;

void main() {
  vec2 from_middle = gl_FragCoord.xy / SUBPIXELS - 0.5 * vec2(view_up.w, view_forward.w);
  vec3 direction = view_right.w * view_forward.xyz + from_middle.x * view_right.xyz -
                   from_middle.y * view_up.xyz;
  float along = dot(direction, picture_forward.xyz);
  vec2 across = vec2(dot(direction, picture_right.xyz), -dot(direction, picture_up.xyz));
  vec2 size = vec2(picture_up.w, picture_forward.w);
  vec2 place = (picture_right.w * across / along + 0.5 * size) / size;
  // Before the discard: neighbours that are gone would leave no derivative.
  vec3 seen = textureGrad(picture_color, place, dFdx(place), dFdy(place)).rgb;
  if (along <= 0.0 || any(lessThan(place, vec2(0))) || any(greaterThan(place, vec2(1)))) discard;
  radiance = vec4(seen, 1);
}
