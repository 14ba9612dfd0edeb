// Mist, undrawn rain and the glow of lamps in them, over the scene's colour: raytrace/rain_fog.h.
// Made only for a scene with [fog]; the glow is compiled only for one with [glow].
#pragma once

#include <array>

#include <glm/vec4.hpp>

#include "raytrace/rain_fog.h"
#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gpu_scene.h"
#include "realtime/scene_pass.h"
#include "realtime/shadow_pass.h"

namespace pluvia {

constexpr int most_fog_slabs = 16;
constexpr int glow_samples = 16;  // of a ray for each light

struct FogUniforms {  // fog_uniforms.glsl, member by member
  GpuCamera camera = {};
  glm::vec4 camera_m = {};
  glm::vec4 box_min_m = {}, box_max_m = {};
  glm::vec4 environment = {};
  glm::vec4 air = {};
  glm::ivec4 counts = {};
  std::array<glm::vec4, most_fog_slabs> slabs = {};
  std::array<glm::vec4, most_fog_slabs> extents = {};
};

struct FogPass {
  const RainSpace* space = nullptr;  // the renderer's
  FogUniforms values = {};
  GlBuffer uniforms = {}, lights = {};
  GlFramebuffer target = {};
  GlVertexArray no_vertices = {};
  ShaderProgram program = {};
};

// Throws std::runtime_error for more than most_fog_slabs directions of fall.
FogPass make_fog_pass(const Scene& scene, const RainSpace& space, const ScenePass& surfaces,
                      const ShadowPass& shadows, const glm::vec4& environment);

// For scene.camera as it is now. Why there is nothing to draw; empty: it was drawn.
std::string draw_fog(FogPass& pass, const Scene& scene, const ScenePass& surfaces,
                     const ShadowPass& shadows);

PlannedPass plan_of(const FogPass& pass);

}  // namespace pluvia
