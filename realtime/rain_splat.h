// Thin streaks without quads or fragments (realtime/shaders/rain_splat.comp): what the rain pass
// keeps for them. Nothing is made where RenderOptions asks for none.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include <glm/vec4.hpp>

#include "atlas/streak_atlas.h"
#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/gpu_atlas.h"
#include "realtime/rain_look.h"
#include "realtime/rain_renderer.h"
#include "realtime/shader.h"

namespace pluvia {

// A longer path is drawn as a quad: no thread walks on when all others of its group are done.
constexpr double longest_splat_px = 64;
// Borders of pixels that a walk may pass: sqrt(2) 64, and the ends.
constexpr int splat_steps = 160;
constexpr int splat_lights = 8;  // walked together
// Quanta of the sums. 2^30 of them are the most that a pixel takes: 16384 times what a PNG shows as
// white, and optical depth 256.
constexpr double quanta_of_white = 1 << 16, quanta_of_share = 1 << 22;

// A streak that may be brighter in a pixel is a quad: a few of them may lie over each other.
constexpr double most_streak_quanta = 1 << 26;

struct RainSplat {
  double widest_px = 0;
  double radiance_quantum_cd_m2 = 0;
  std::shared_ptr<const GpuProfiles> atlas = {};
  GlBuffer sums = {}, overflow = {};
  ShaderProgram program = {};

  bool empty() const { return sums.id() == 0; }
};

struct SplatUniforms {  // of RainUniforms
  glm::vec4 splat = {};
  glm::vec4 most = {};
  glm::ivec4 levels = {};
};

// Why no streak is drawn by rain_splat.comp, although options ask for it: a shader may see only
// most_bytes of the sums. Empty: it sees them.
std::string why_all_quads(const Camera& camera, std::size_t most_bytes);

// Empty where options ask for none, or why_all_quads says so. atlas: what the look needs of it.
// kept: of an earlier pass of the same atlas. The program comes from the rain pass. Throws
// std::runtime_error for options out of range.
RainSplat make_rain_splat(const Scene& scene, const StreakAtlas& atlas,
                          const RenderOptions& options, const RainLook& look, int sky_cells,
                          std::shared_ptr<const GpuProfiles> kept, SplatUniforms& uniforms);

void clear_splat(const RainSplat& splat);

// Whether a sum or a value was beyond what integers hold.
bool splat_overflowed(const RainSplat& splat);

void plan_splat(const RainSplat& splat, PlannedPass& plan);

}  // namespace pluvia
