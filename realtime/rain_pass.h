// Rain over a scene: drops from their seed, one record per visible drop, one quad per record, added
// up into radiance and optical depth.
#pragma once

#include <cstddef>

#include <glm/vec4.hpp>

#include "atlas/streak_atlas.h"
#include "raytrace/scene.h"
#include "realtime/gl_objects.h"
#include "realtime/gpu_scene.h"
#include "realtime/rain_renderer.h"
#include "realtime/scene_pass.h"
#include "realtime/streak_record.h"

namespace pluvia {

struct RainUniforms {  // rain_uniforms.glsl, member by member
  GpuCamera camera = {};
  glm::vec4 box_corner_m = {};
  glm::vec4 box_size_m = {};
  glm::vec4 velocity_m_s = {};
  glm::vec4 top_grid_m = {};
  glm::vec4 cell = {};
  glm::vec4 environment = {};
  glm::uvec4 fall = {};
  glm::ivec4 counts = {};
  glm::ivec4 sizes = {};
};

struct RainPass {
  Rain rain = {};
  RainUniforms uniforms = {};
  std::size_t sums_bytes = 0;
  std::size_t capacity = 0;  // streaks that the record buffers hold
  GlBuffer uniform_buffer = {}, group_starts = {}, refused = {}, streaks = {}, lit_streaks = {};
  GlBuffer lights = {}, atlas_lights = {}, atlas_layers = {}, atlas_views = {}, atlas_spans = {};
  GlBuffer quad_indices = {};
  GlTexture top_height = {}, sums = {};
  GlVertexArray quads = {};
  GlProgram count = {}, place = {}, draw = {}, centres = {};
};

// Throws std::runtime_error when scene and atlas do not agree or do not fit this OpenGL.
RainPass make_rain_pass(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options,
                        const glm::vec4& environment);

// Fills the records for a shutter that opens at time_s; returns how many drops are in view. Throws
// std::runtime_error for a time that fall_state refuses and for a lamp inside a drop.
long place_rain(RainPass& pass, double time_s);

// Adds the records to the target (RGBA32F and a depth for the test).
void draw_rain(const RainPass& pass, const GlFramebuffer& target);

StreakRecords read_records(const RainPass& pass);

// Three floats a drop, from the camera.
std::vector<float> read_centres_m(RainPass& pass, double time_s);

}  // namespace pluvia
