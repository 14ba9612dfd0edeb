// The scene with rain over it: C = exp(-tau) B + S.
#pragma once

#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct CompositePass {
  GlTexture color = {}, background = {};
  GlFramebuffer target = {};
  GlVertexArray no_vertices = {};
  ShaderProgram program = {};
};

// rain: whether there is any.
CompositePass make_composite_pass(int width, int height, bool rain);

// rain: RGBA32F, radiance and tau; nullptr without any.
void draw_composite(const CompositePass& pass, const ScenePass& scene, const GlTexture* rain);

PlannedPass plan_of(const CompositePass& pass);

}  // namespace pluvia
