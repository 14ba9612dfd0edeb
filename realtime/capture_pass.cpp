#include "realtime/capture_pass.h"

#include <array>

#include <glm/vec3.hpp>

namespace pluvia {
namespace {

struct Face {
  glm::vec3 forward, right, down;
};

// In the order and with the axes of OpenGL's cube maps (specification 4.5, table 8.19): rows of a
// face go down, and the axes are left-handed.
const std::array<Face, 6> cube_faces = {{{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                         {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                         {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
                                         {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                         {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},
                                         {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}}};

GpuCamera face_camera(const Face& face, float size_px) {
  return {glm::vec4(face.right, size_px / 2), glm::vec4(-face.down, size_px),
          glm::vec4(face.forward, size_px)};
}

GpuCamera wide_camera(const GpuCamera& camera, float size_px) {
  return {glm::vec4(glm::vec3(camera.right), size_px / 2 / static_cast<float>(wide_tangent)),
          glm::vec4(glm::vec3(camera.up), size_px), glm::vec4(glm::vec3(camera.forward), size_px)};
}

}  // namespace

int capture_levels(const CapturePass& pass) {
  return all_levels(pass.size_px, pass.size_px);
}

CapturePass make_capture_pass(SceneCapture kind, int size_px) {
  CapturePass pass = {.kind = kind, .size_px = size_px};
  pass.picture = make_filtered(kind == SceneCapture::cube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D,
                               size_px, size_px);
  pass.depth = make_texture(GL_DEPTH_COMPONENT32F, size_px, size_px);
  if (kind == SceneCapture::wide) {
    pass.faces.push_back(make_framebuffer({pass.picture.id()}, pass.depth.id()));
    return pass;
  }
  for (GLint face = 0; face < 6; ++face) {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    pass.faces.emplace_back(id);
    glNamedFramebufferTextureLayer(id, GL_COLOR_ATTACHMENT0, pass.picture.id(), 0, face);
    glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, pass.depth.id(), 0);
  }
  return pass;
}

void draw_capture(const CapturePass& pass, const ScenePass& surfaces, const ShadowPass& shadows,
                  const PicturePass* picture) {
  // As many of the scene's pixels as the picture's texels are samples of.
  const float size_px = static_cast<float>(pass.size_px) / subpixels;
  for (std::size_t i = 0; i < pass.faces.size(); ++i) {
    const GpuCamera camera = pass.kind == SceneCapture::cube
                                 ? face_camera(cube_faces[i], size_px)
                                 : wide_camera(surfaces.values.camera, size_px);
    draw_view(surfaces, shadows, camera, pass.faces[i], pass.size_px);
    if (picture)
      draw_picture_view(*picture, surfaces.values.camera, camera, pass.faces[i], pass.size_px);
  }
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glGenerateTextureMipmap(pass.picture.id());
}

PlannedPass plan_of(const CapturePass& pass) {
  PlannedPass plan = {.name = "surroundings"};
  plan.notes.push_back(
      pass.kind == SceneCapture::cube
          ? "the scene around the camera as a cube map, without fog and darkening"
          : "the scene before the camera, 165 degrees wide, without fog and darkening");
  plan.add("picture", pass.picture);
  plan.add("depth", pass.depth);
  return plan;
}

}  // namespace pluvia
