#include "realtime/composite_pass.h"

#include <string>

#include <fmt/format.h>

#include "realtime/shader.h"

namespace pluvia {
namespace {

enum TextureUnit : GLuint { scene_color_at, rain_at, coverage_at };
enum Binding : GLuint { splat_sums_at };

bool has_splat(const RainPass* rain) {
  return rain && !rain->splat.empty();
}

}  // namespace

CompositePass make_composite_pass(int width, int height, const RainPass* rain, GLenum format) {
  CompositePass pass;
  pass.color = make_texture(format, width, height);
  pass.background = make_texture(GL_RGBA32F, width, height);
  pass.target = rain ? make_framebuffer({pass.color.id(), pass.background.id(), rain->seen.id()}, 0)
                     : make_framebuffer({pass.color.id(), pass.background.id()}, 0);
  pass.no_vertices = make_vertex_array();
  pass.program = build_program(
      {"screen.vert", "composite.frag"},
      {{"WITH_RAIN", rain ? "1" : "0"},
       {"WITH_SPLAT", has_splat(rain) ? "1" : "0"},
       {"SPLAT_SUMS", std::to_string(splat_sums_at)},
       {"RADIANCE_QUANTUM",
        fmt::format("{:.9e}", has_splat(rain) ? rain->splat.radiance_quantum_cd_m2 : 0)},
       {"SHARE_QUANTUM", fmt::format("{:.9e}", 1 / quanta_of_share)},
       {"SCENE_COLOR", std::to_string(scene_color_at)},
       {"RAIN", std::to_string(rain_at)},
       {"COVERAGE", std::to_string(coverage_at)},
       {"SUBPIXELS", std::to_string(subpixels)}});
  return pass;
}

void draw_composite(const CompositePass& pass, const ScenePass& scene, const RainPass* rain) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, pass.target.id());
  glViewport(0, 0, scene.width, scene.height);
  glBindTextureUnit(scene_color_at, scene.color.id());
  if (rain) {
    glBindTextureUnit(rain_at, rain->sum.id());
    glBindTextureUnit(coverage_at, rain->coverage.id());
  }
  if (has_splat(rain))
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, splat_sums_at, rain->splat.sums.id());
  glUseProgram(pass.program.id());
  glBindVertexArray(pass.no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

PlannedPass plan_of(const CompositePass& pass) {
  PlannedPass plan = {.name = "composite"};
  plan.add(pass.program);
  plan.add("picture", pass.color);
  plan.add("picture without rain", pass.background);
  return plan;
}

}  // namespace pluvia
