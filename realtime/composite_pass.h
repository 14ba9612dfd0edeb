// The scene with rain over it: C = exp(-tau) B + S.
#pragma once

#include "realtime/gl_objects.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct CompositePass {
  GlTexture color = {}, background = {};
  GlFramebuffer target = {};
  GlVertexArray no_vertices = {};
  GlProgram program = {};
};

CompositePass make_composite_pass(int width, int height);

// rain: RGBA32F, radiance and tau.
void draw_composite(const CompositePass& pass, const ScenePass& scene, const GlTexture& rain);

}  // namespace pluvia
