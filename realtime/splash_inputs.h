// What the splash pass hands to its shaders: the tables of raytrace/splash.h.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "raytrace/splash_space.h"

namespace pluvia {

struct SplashUniforms {  // splash_inputs.glsl, member by member
  glm::vec4 box_min_m = {}, box_max_m = {};
  glm::vec4 air = {};
};

struct GpuSplashSize {
  glm::vec4 crown = {}, impact = {};
  glm::ivec4 parts = {};
};

struct GpuSplashPart {
  glm::vec4 first = {}, velocity = {}, more = {};
};

// The parts of all tables, one after the other, and where those of each of RainSpace::sizes are.
std::vector<GpuSplashPart> gpu_splash_parts(const SplashSpace& splashes);
std::vector<GpuSplashSize> gpu_splash_sizes(const SplashSpace& splashes);

}  // namespace pluvia
