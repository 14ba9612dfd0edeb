#version 450 core
// The pictures of a streak's cells, filtered trilinearly inside the cell, blended by coverage.
#include "rain_picture.glsl"

layout(std430, binding = ATLAS_VIEWS) readonly buffer AtlasViews { vec4 atlas_views[]; };
layout(std430, binding = ATLAS_LAYERS) readonly buffer AtlasLayers { int mirrored_layer[]; };
layout(binding = POINT_PICTURES) uniform sampler2DArray point_pictures;
layout(binding = ENVIRONMENT_PICTURES) uniform sampler2DArray environment_pictures;
layout(binding = COVERAGE_PICTURES) uniform sampler2DArray coverage_pictures;

flat in ivec2 view;
flat in vec2 view_weight;
flat in vec3 rows;
flat in int layer;
flat in vec3 lux[BILLBOARD_LIGHTS];
flat in uint cells[BILLBOARD_LIGHTS];
in vec2 place;
layout(location = 0) out vec4 color;

// What a cell shows: columns from `column` on, of `set`, in the rows of a view.
float shown(sampler2DArray pictures, int column, int set, vec2 texel, float lod, vec4 of_view) {
  float half_texel = min(0.5 * exp2(lod), 0.5 * cell.y);
  vec2 inside = clamp(texel, vec2(half_texel), max(vec2(cell.y, of_view.w) - half_texel, half_texel));
  vec2 size = vec2(textureSize(pictures, 0).xy);
  return textureLod(pictures, vec3((vec2(float(column) * cell.y, of_view.z) + inside) / size, float(set)), lod).r;
}

void add_view(int which, float weight, float lod, inout vec3 light, inout float coverage) {
  vec4 of_view = atlas_views[which];
  vec2 texel = vec2(place.x * cell.y, cell_row(place.y, rows.x, of_view.y));
  // As much light on a shorter path.
  float stretch = place.y > cell.x && place.y < cell.x + rows.x ? of_view.y / rows.x : 1.0;
  for (int i = 0; i < counts.y; ++i) {
    bool mirrored = (cells[i] & 1u) != 0u;
    vec2 at = mirrored ? vec2(cell.y - texel.x, texel.y) : texel;
    light += weight * stretch * lux[i] *
             shown(point_pictures, int(cells[i] >> 1 & 0x7fffu), int(cells[i] >> 16), at, lod, of_view);
  }
#if SKY_CELLS
  light += weight * stretch * rows.z * environment.rgb *
           shown(environment_pictures, 0, layer, texel, lod, of_view);
#endif
  coverage += weight * stretch * shown(coverage_pictures, 0, layer, texel, lod, of_view);
}

void main() {
  vec2 texel = place * vec2(cell.y, 1.0);
  float lod = max(log2(max(length(dFdx(texel)), length(dFdy(texel)))), 0.0);
  vec3 light = vec3(0);
  float coverage = 0.0;
  add_view(view.x, view_weight.x, lod, light, coverage);
  if (view_weight.y > 0.0) add_view(view.y, view_weight.y, lod, light, coverage);
  color = vec4(light, clamp(coverage, 0.0, 1.0));
}
