#include "realtime/fog_pass.h"

#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "realtime/shader.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

enum Binding : GLuint { uniforms_at, lights_at, depth_at, shadow_views_at, shadow_maps_at };

// Beyond it a lamp's glow is not followed.
constexpr double glow_reach_m = 500;

ShaderDefines defines(const Scene& scene, const ShadowPass& shadows) {
  return {{"FOG_UNIFORMS", std::to_string(uniforms_at)},
          {"LIGHTS", std::to_string(lights_at)},
          {"SURFACE_DEPTH", std::to_string(depth_at)},
          {"SHADOWS", shadows.empty() ? "0" : "1"},
          {"SHADOW_VIEWS", std::to_string(shadow_views_at)},
          {"SHADOW_MAPS", std::to_string(shadow_maps_at)},
          {"MOST_SLABS", std::to_string(most_fog_slabs)},
          {"GLOW", scene.glow ? "1" : "0"},
          {"GLOW_SAMPLES", std::to_string(glow_samples)},
          {"SUBPIXELS", std::to_string(subpixels)},
          {"NEAR_M", std::to_string(near_m)}};
}

void set_values(FogPass& pass, const Scene& scene, const ScenePass& surfaces) {
  const RainFog fog = rain_fog(scene, *pass.space);
  FogUniforms& values = pass.values;
  values.camera = gpu_camera(scene.camera);
  values.camera_m = to_glm(scene.camera.position_m - surfaces.origin_m, 0);
  values.box_min_m = to_glm(fog.box_min_m, 0);
  values.box_max_m = to_glm(fog.box_max_m, 0);
  values.air =
      to_glm({fog.everywhere_per_m, fog.culling_radius_m, scene.fog->asymmetry}, glow_reach_m);
  values.counts = {static_cast<int>(fog.slabs.size()), static_cast<int>(scene.lights.size()), 0, 0};
  for (std::size_t i = 0; i < fog.slabs.size(); ++i) {
    values.slabs[i] = to_glm(fog.slabs[i].against_fall, fog.slabs[i].per_m);
    values.extents[i] = to_glm({fog.slabs[i].low_m, fog.slabs[i].high_m, 0}, 0);
  }
}

bool is_clear(const FogUniforms& values) {
  bool clear = values.air.x == 0;
  for (int i = 0; i < values.counts.x; ++i)
    clear = clear && values.slabs[static_cast<std::size_t>(i)].w == 0;
  return clear;
}

}  // namespace

FogPass make_fog_pass(const Scene& scene, const RainSpace& space, const ScenePass& surfaces,
                      const ShadowPass& shadows, const glm::vec4& environment) {
  FogPass pass;
  pass.space = &space;
  const std::size_t slabs = rain_fog(scene, space).slabs.size();
  if (slabs > most_fog_slabs)
    throw std::runtime_error(fmt::format("fog: rain of {} directions of fall; expected at most {}",
                                         slabs, most_fog_slabs));
  pass.values.environment = environment;
  pass.uniforms = make_buffer(&pass.values, sizeof(pass.values));
  if (scene.glow) pass.lights = make_buffer(gpu_lights(scene, shadows.slots));
  pass.target = make_framebuffer({surfaces.color.id()}, 0);
  pass.no_vertices = make_vertex_array();
  pass.program = build_program({"screen.vert", "fog.frag"}, defines(scene, shadows));
  return pass;
}

std::string draw_fog(FogPass& pass, const Scene& scene, const ScenePass& surfaces,
                     const ShadowPass& shadows) {
  set_values(pass, scene, surfaces);
  if (is_clear(pass.values)) return "the air is clear";
  glNamedBufferSubData(pass.uniforms.id(), 0, sizeof(pass.values), &pass.values);
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniforms.id());
  if (scene.glow) {
    update_buffer(pass.lights, gpu_lights(scene, shadows.slots));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, lights_at, pass.lights.id());
  }
  if (!shadows.empty()) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, shadow_views_at, shadows.view_buffer.id());
    glBindTextureUnit(shadow_maps_at, shadows.maps.id());
  }
  glBindTextureUnit(depth_at, surfaces.color_depth.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, pass.target.id());
  glViewport(0, 0, subpixels * surfaces.width, subpixels * surfaces.height);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_SRC_ALPHA);
  glUseProgram(pass.program.id());
  glBindVertexArray(pass.no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return "";
}

PlannedPass plan_of(const FogPass& pass) {
  PlannedPass plan = {.name = "fog"};
  plan.add(pass.program);
  plan.add("uniforms", pass.uniforms);
  plan.add("lights", pass.lights);
  return plan;
}

}  // namespace pluvia
