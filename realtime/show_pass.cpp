#include "realtime/show_pass.h"

#include <string>

namespace pluvia {
namespace {

constexpr GLuint picture_at = 0;

}  // namespace

ShowPass make_show_pass() {
  return {.no_vertices = make_vertex_array(),
          .program = build_program({"screen.vert", "show.frag"},
                                   {{"PICTURE", std::to_string(picture_at)}})};
}

void show_picture(const ShowPass& pass, const GlTexture& picture, double white, GLuint framebuffer,
                  int width, int height) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glBindTextureUnit(picture_at, picture.id());
  glUseProgram(pass.program.id());
  glUniform1f(0, static_cast<float>(white));
  glUniform2i(1, width, height);
  glBindVertexArray(pass.no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace pluvia
