#include "realtime/picture_pass.h"

#include <cassert>
#include <string>

#include "realtime/shader.h"

namespace pluvia {
namespace {

enum TextureUnit : GLuint { color_at, depth_at };
constexpr GLuint views_at = 0;

struct PictureViews {  // picture_view.frag
  GpuCamera picture = {}, view = {};
};

ShaderProgram picture_program(bool depth_alone) {
  return build_program({"screen.vert", "picture.frag"},
                       {{"PICTURE_COLOR", std::to_string(color_at)},
                        {"PICTURE_DEPTH", std::to_string(depth_at)},
                        {"DEPTH_ALONE", depth_alone ? "1" : "0"},
                        {"SUBPIXELS", std::to_string(depth_alone ? 1 : subpixels)},
                        {"NEAR_M", std::to_string(near_m)}});
}

void upload(const GlTexture& texture, const Image& image, GLenum order) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.id(), 0, 0, 0, image.width, image.height, order, GL_FLOAT,
                      image.values.data());
}

void draw_into(const GlFramebuffer& target, int width, int height, const ShaderProgram& program) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.id());
  glViewport(0, 0, width, height);
  glUseProgram(program.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

PicturePass make_picture_pass(const ScenePass& targets, bool refracted) {
  PicturePass pass;
  pass.color = refracted ? make_filtered(GL_TEXTURE_2D, targets.width, targets.height)
                         : make_texture(GL_RGB32F, targets.width, targets.height);
  if (refracted) {
    pass.draw_view = build_program({"screen.vert", "picture_view.frag"},
                                   {{"PICTURE_COLOR", std::to_string(color_at)},
                                    {"PICTURE_VIEWS", std::to_string(views_at)},
                                    {"SUBPIXELS", std::to_string(subpixels)}});
    pass.views = make_buffer(nullptr, sizeof(PictureViews));
  }
  pass.depth_m = make_texture(GL_R32F, targets.width, targets.height);
  pass.no_vertices = make_vertex_array();
  pass.draw_color = picture_program(false);
  pass.draw_depth = picture_program(true);
  return pass;
}

void set_picture(PicturePass& pass, const Picture& picture) {
  upload(pass.color, picture.color, GL_RGB);
  if (pass.views.id() != 0) glGenerateTextureMipmap(pass.color.id());
  upload(pass.depth_m, picture.depth_m, GL_RED);
  pass.shown = true;
}

void draw_picture(const PicturePass& pass, const ScenePass& targets) {
  assert(pass.shown);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);  // without it no depth is written
  glDepthFunc(GL_ALWAYS);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glBindTextureUnit(color_at, pass.color.id());
  glBindTextureUnit(depth_at, pass.depth_m.id());
  glBindVertexArray(pass.no_vertices.id());
  draw_into(targets.color_target, subpixels * targets.width, subpixels * targets.height,
            pass.draw_color);
  draw_into(targets.depth_target, targets.width, targets.height, pass.draw_depth);
  glDepthFunc(GL_GREATER);  // as every other pass expects it
}

void draw_picture_view(const PicturePass& pass, const GpuCamera& picture_camera,
                       const GpuCamera& camera, const GlFramebuffer& target, int size_px) {
  const PictureViews views = {picture_camera, camera};
  glNamedBufferSubData(pass.views.id(), 0, sizeof(views), &views);
  glBindBufferBase(GL_UNIFORM_BUFFER, views_at, pass.views.id());
  glBindTextureUnit(color_at, pass.color.id());
  glBindVertexArray(pass.no_vertices.id());
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  draw_into(target, size_px, size_px, pass.draw_view);
  glEnable(GL_DEPTH_TEST);
}

PlannedPass plan_of(const PicturePass& pass, const ScenePass& targets) {
  PlannedPass plan = plan_of(targets);
  plan.name = "picture";
  plan.add(pass.draw_color);
  plan.add(pass.draw_depth);
  plan.add(pass.draw_view);
  plan.add("picture that is given", pass.color);
  plan.add("depth that is given", pass.depth_m);
  return plan;
}

}  // namespace pluvia
