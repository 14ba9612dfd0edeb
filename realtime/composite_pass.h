// The scene with rain over it (realtime/shaders/composite.frag).
#pragma once

#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/rain_pass.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct CompositePass {
  GlTexture color = {}, background = {};
  GlFramebuffer target = {};
  GlVertexArray no_vertices = {};
  ShaderProgram program = {};
};

// rain: nullptr without any, or where it is drawn over the picture later. format: of the picture.
CompositePass make_composite_pass(int width, int height, const RainPass* rain,
                                  GLenum format = GL_RGBA32F);

// The same rain.
void draw_composite(const CompositePass& pass, const ScenePass& scene, const RainPass* rain);

PlannedPass plan_of(const CompositePass& pass);

}  // namespace pluvia
