#include "realtime/gl_objects.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>

namespace pluvia {

GlBuffer make_buffer(const void* data, std::size_t bytes) {
  static constexpr std::array<char, 16> zeros = {};
  GLuint id = 0;
  glCreateBuffers(1, &id);
  if (bytes == 0)
    glNamedBufferStorage(id, zeros.size(), zeros.data(), 0);
  else
    glNamedBufferStorage(id, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
  return GlBuffer(id);
}

GlTexture make_texture(GLenum format, int width, int height) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &id);
  glTextureStorage2D(id, 1, format, width, height);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return GlTexture(id);
}

int all_levels(int width, int height) {
  return std::bit_width(static_cast<unsigned>(std::max(width, height)));
}

GlTexture make_filtered(GLenum target, int width, int height) {
  GLuint id = 0;
  glCreateTextures(target, 1, &id);
  glTextureStorage2D(id, all_levels(width, height), GL_RGBA32F, width, height);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return GlTexture(id);
}

GlTexture make_folded_array(GLenum format, GLenum order, int channels, int layer_width,
                            int layer_height, std::vector<float>& values) {
  const auto wide = static_cast<std::size_t>(layer_width) * static_cast<std::size_t>(channels);
  const std::size_t layer = wide * static_cast<std::size_t>(layer_height);
  const std::size_t layers = (values.size() + layer - 1) / layer;
  const std::size_t rows =
      layers > 1 ? static_cast<std::size_t>(layer_height) : (values.size() + wide - 1) / wide;
  values.resize(layers * rows * wide);
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  glTextureStorage3D(id, 1, format, layer_width, static_cast<GLsizei>(rows),
                     static_cast<GLsizei>(layers));
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(id, 0, 0, 0, 0, layer_width, static_cast<GLsizei>(rows),
                      static_cast<GLsizei>(layers), order, GL_FLOAT, values.data());
  return texture;
}

GlFramebuffer make_framebuffer(std::initializer_list<GLuint> colors, GLuint depth) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  GlFramebuffer framebuffer(id);
  std::vector<GLenum> targets;
  for (const GLuint color : colors) {
    targets.push_back(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + targets.size()));
    glNamedFramebufferTexture(id, targets.back(), color, 0);
  }
  if (depth) glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth, 0);
  glNamedFramebufferDrawBuffers(id, static_cast<GLsizei>(targets.size()), targets.data());
  if (glCheckNamedFramebufferStatus(id, GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error(
        "OpenGL: an incomplete framebuffer; expected 32-bit float targets to "
        "be drawable");
  return framebuffer;
}

GlVertexArray make_vertex_array() {
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  return GlVertexArray(id);
}

namespace {

Image read_channels(const GlTexture& texture, int width, int height, GLenum format, int channels) {
  Image image = make_image(width, height, channels);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(texture.id(), 0, format, GL_FLOAT,
                    static_cast<GLsizei>(image.values.size() * sizeof(float)), image.values.data());
  return image;
}

}  // namespace

Image read_texture(const GlTexture& texture, int width, int height, int channels) {
  return read_channels(texture, width, height, channels == 1 ? GL_RED : GL_RGB, channels);
}

Image read_alpha(const GlTexture& texture, int width, int height) {
  return read_channels(texture, width, height, GL_ALPHA, 1);
}

}  // namespace pluvia
