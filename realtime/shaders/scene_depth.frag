#version 450 core
// Distance along the camera's axis in m.
in float surface_depth_m;
layout(location = 0) out float depth_m;

void main() { depth_m = surface_depth_m; }
