// How much of a light reaches a point past the surfaces: the maps of realtime/shadow_pass.h. Where no
// light of the scene casts a shadow the function is a constant and there is nothing to bind.
#if SHADOWS
layout(std430, binding = SHADOW_VIEWS) readonly buffer ShadowViews { mat4 shadow_views[]; };
layout(binding = SHADOW_MAPS) uniform sampler2DArrayShadow shadow_maps;

// Of the cube around a point light: +x, -x, +y, -y, +z, -z.
int cube_face(vec3 away) {
  vec3 size = abs(away);
  if (size.x >= size.y && size.x >= size.z) return away.x > 0.0 ? 0 : 1;
  if (size.y >= size.z) return away.y > 0.0 ? 2 : 3;
  return away.z > 0.0 ? 4 : 5;
}

// place_m: from the vertices' origin. toward: the light.
float lit_share(Light light, vec3 place_m, vec3 toward) {
  int map = int(light.more.y);
  if (map < 0) return 1.0;
  if (light.more.z > 1.0) map += cube_face(-toward);
  vec4 seen = shadow_views[map] * vec4(place_m, 1);
  if (!(seen.w > 0.0)) return 1.0;
  vec3 at = seen.xyz / seen.w;
  // Beyond the map nothing stands in the way.
  if (any(greaterThan(abs(at.xy), vec2(1)))) return 1.0;
  return texture(shadow_maps, vec4(0.5 * at.xy + 0.5, float(map), clamp(at.z, 0.0, 1.0)));
}
#else
float lit_share(Light light, vec3 place_m, vec3 toward) { return 1.0; }
#endif
