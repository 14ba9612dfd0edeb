// Mirrors SceneUniforms of realtime/scene_pass.h.
layout(std140, binding = SCENE_UNIFORMS) uniform SceneUniforms {
  vec4 camera_right;    // w: focal length in px
  vec4 camera_up;       // w: picture width in px
  vec4 camera_forward;  // w: picture height in px
  vec4 camera_m;        // from the origin of the vertices
  vec4 ambient;         // mean radiance of the environment in cd/m^2; w: 1 when there is a map
  vec4 sky;             // what multiplies the map, or the uniform radiance; w: number of lights
};
