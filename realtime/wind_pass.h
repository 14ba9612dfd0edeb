// Rain that wind moves by steps (raytrace/drop_motion.h), on the GPU: its state, and the shader
// that takes the steps. Made only for a scene with wind primitives; every other scene's rain has
// the closed form, and no buffer, shader or pass of this. A time is reached from the last one by
// the steps between, or from 0 when it lies behind: the same drops either way.
#pragma once

#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "raytrace/drop_motion.h"
#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/shader.h"

namespace pluvia {

struct GpuMovingDrop {        // MovingDrop of wind_drops.glsl
  glm::vec4 position_m = {};  // w: since_hit_s
  float velocity_m_s[3] = {};
  std::uint32_t fall = 0;
};

struct GpuMovingSize {  // MovingSize of wind_step.comp
  glm::vec4 fall_m_s = {};
  glm::uvec4 drops = {};
};

struct WindUniforms {  // wind_step.comp, member by member
  glm::vec4 size_m = {};
  glm::vec4 node_step_m = {};
  glm::vec4 top_grid = {};
  glm::ivec4 top_layout = {};
};

struct WindPass {
  Scene scene = {};        // its moving parts, posed for the last stage
  DropMotion motion = {};  // without its drops
  GlBuffer drops = {}, sizes = {}, wind = {}, top_heights = {}, uniforms = {};
  ShaderProgram step = {};
};

// For a scene that needs_motion. Throws std::runtime_error as make_drop_motion, and where the drops
// do not fit this OpenGL.
WindPass make_wind_pass(const Scene& scene);

// Moves the drops to the last step before a time. Why no step was taken; empty: one was.
std::string step_wind(WindPass& pass, double time_s);

// From the next step on.
void change_wind(WindPass& pass, const std::vector<WindPrimitive>& primitives);

// Seconds from the last step to a time.
double late_s(const WindPass& pass, double time_s);

PlannedPass plan_of(const WindPass& pass);

// What the shader has made of the drops.
std::vector<MovingDrop> read_moving_drops(const WindPass& pass);

}  // namespace pluvia
