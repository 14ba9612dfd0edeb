// What the GPU decides about each stroke of a splash: drawn by splash.vert and splash.frag, read
// back by tests.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

namespace pluvia {

struct StrokeRecord {  // Stroke of splash_strokes.glsl
  glm::vec2 centre_px = {}, half_axis_px = {};
  float half_width_px = 0;
  float area_px = 0;
  float inverse_depth = 0;
  float weight = 0;
  glm::vec4 radiance = {};
};
static_assert(sizeof(StrokeRecord) == 48);

}  // namespace pluvia
