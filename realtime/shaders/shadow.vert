#version 450 core
// A surface as a light sees it: the matrices of realtime/shadow_pass.h.
layout(location = 0) in vec3 placed_m;
layout(location = 0) uniform mat4 view;

void main() { gl_Position = view * vec4(placed_m, 1); }
