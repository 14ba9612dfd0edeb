// Shadows of surfaces, for the lights that ask for them: depth maps from the light, drawn once,
// and again whenever surfaces have moved. A point light has six (the faces of a cube around it), a
// narrow spot one, the sun one over all of the surfaces wherever they move. Without such a light
// there is no map and no pass.
//
// A map holds 2 cm / distance along its axis (the sun: 1 - distance / depth of its box), in 32-bit
// float: the nearest surface has the greatest value. A point is lit where its own value is at least
// the map's, over the four nearest texels.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>

#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct ShadowPass {
  std::vector<ShadowSlot> slots = {};  // of each light
  std::vector<glm::mat4> views = {};   // of each map, from scene_pass.h's origin
  GlTexture maps = {};                 // 0 without any
  GlBuffer view_buffer = {};
  ShaderProgram program = {};

  bool empty() const { return views.empty(); }
};

// Renders the maps. surfaces: the pass that holds the vertices. Throws std::runtime_error when this
// OpenGL cannot hold so many.
ShadowPass make_shadow_pass(const Scene& scene, const ScenePass& surfaces);

// Renders the maps anew from the vertices as they are now.
void draw_shadow_maps(const ShadowPass& pass, const ScenePass& surfaces);

PlannedPass plan_of(const ShadowPass& pass);

}  // namespace pluvia
