#include "realtime/composite_pass.h"

#include <string>

#include "realtime/shader.h"

namespace pluvia {
namespace {

enum Binding : GLuint { scene_color_at, rain_at, coverage_at };

}  // namespace

CompositePass make_composite_pass(int width, int height, const RainPass* rain) {
  CompositePass pass;
  pass.color = make_texture(GL_RGBA32F, width, height);
  pass.background = make_texture(GL_RGBA32F, width, height);
  pass.target = rain ? make_framebuffer({pass.color.id(), pass.background.id(), rain->seen.id()}, 0)
                     : make_framebuffer({pass.color.id(), pass.background.id()}, 0);
  pass.no_vertices = make_vertex_array();
  pass.program = build_program({"screen.vert", "composite.frag"},
                               {{"WITH_RAIN", rain ? "1" : "0"},
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
