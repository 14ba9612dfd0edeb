// Owning handles of OpenGL objects, and the few ways in which the passes make them. The context
// that made an object must be current when it is destroyed.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "atlas/image.h"

namespace pluvia {

inline void delete_buffer(GLuint id) {
  glDeleteBuffers(1, &id);
}
inline void delete_texture(GLuint id) {
  glDeleteTextures(1, &id);
}
inline void delete_framebuffer(GLuint id) {
  glDeleteFramebuffers(1, &id);
}
inline void delete_vertex_array(GLuint id) {
  glDeleteVertexArrays(1, &id);
}
inline void delete_program(GLuint id) {
  glDeleteProgram(id);
}
inline void delete_shader(GLuint id) {
  glDeleteShader(id);
}

template <void (*destroy)(GLuint)>
class GlHandle {
 public:
  GlHandle() = default;
  explicit GlHandle(GLuint id) : id_(id) {}
  ~GlHandle() {
    if (id_) destroy(id_);
  }
  GlHandle(GlHandle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

using GlBuffer = GlHandle<delete_buffer>;
using GlTexture = GlHandle<delete_texture>;
using GlFramebuffer = GlHandle<delete_framebuffer>;
using GlVertexArray = GlHandle<delete_vertex_array>;
using GlProgram = GlHandle<delete_program>;
using GlShader = GlHandle<delete_shader>;

// bytes = 0 gives a buffer of 16 bytes of zeros, because a shader cannot bind an empty one.
GlBuffer make_buffer(const void* data, std::size_t bytes);

template <class T>
GlBuffer make_buffer(const std::vector<T>& values) {
  return make_buffer(values.data(), values.size() * sizeof(T));
}

// Values from place `first` on, of those that the buffer was made with.
template <class T>
void update_values(const GlBuffer& buffer, std::size_t first, const std::vector<T>& values) {
  if (values.empty()) return;
  glNamedBufferSubData(buffer.id(), static_cast<GLintptr>(first * sizeof(T)),
                       static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data());
}

// The same number of values as the buffer was made with.
template <class T>
void update_buffer(const GlBuffer& buffer, const std::vector<T>& values) {
  update_values(buffer, 0, values);
}

// One level, nearest filter, clamped at the edges. format: a sized internal format.
GlTexture make_texture(GLenum format, int width, int height);

// Mip levels down to a single texel.
int all_levels(int width, int height);

// RGBA32F with all levels, linear in and between them; a cube map, or of two dimensions.
GlTexture make_filtered(GLenum target, int width, int height);

// One long array of `channels` floats each, folded into layers: a storage buffer may be limited to
// 128 MB. Padded with zeros to whole rows, or layers where there are several.
GlTexture make_folded_array(GLenum format, GLenum order, int channels, int layer_width,
                            int layer_height, std::vector<float>& values);

// depth: 0 for none. Draws into the colours in order. Throws std::runtime_error when incomplete.
GlFramebuffer make_framebuffer(std::initializer_list<GLuint> colors, GLuint depth);

GlVertexArray make_vertex_array();

// The first `channels` (1 or 3) channels of a floating-point texture, and its alpha, as 32-bit
// floats.
Image read_texture(const GlTexture& texture, int width, int height, int channels);
Image read_alpha(const GlTexture& texture, int width, int height);

}  // namespace pluvia
