// Mirrors FogUniforms of realtime/fog_pass.h.
layout(std140, binding = FOG_UNIFORMS) uniform FogUniforms {
  vec4 fog_camera_right;         // w: focal length in px
  vec4 fog_camera_up;            // w: picture width in px
  vec4 fog_camera_forward;       // w: picture height in px
  vec4 fog_camera_m;             // from the origin of the shadow maps
  vec4 fog_box_min_m;            // from the camera
  vec4 fog_box_max_m;
  vec4 fog_environment;          // mean radiance in cd/m^2
  vec4 fog_air;                  // extinction everywhere, culling radius, asymmetry, reach of the glow
  ivec4 fog_counts;              // slabs, lights
  vec4 fog_slabs[MOST_SLABS];    // against the fall; extinction where it is not drawn
  vec4 fog_extents[MOST_SLABS];  // of the local slab along it
};
