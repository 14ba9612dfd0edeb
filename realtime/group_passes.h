// What the passes over groups of drops share (realtime/shaders/rain_group.glsl): one group of
// threads for each, which count what they draw, and again to write it, in order.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "realtime/gl_objects.h"
#include "realtime/shader.h"

namespace pluvia {

constexpr int group_size = 256;  // threads of a group, a drop each
// Drops and segments of a GpuDropGroup of the rain, which such a group of threads has several of:
// all of a cell, so that the fewer the better they fill the threads.
constexpr int drops_of_group = 32;
constexpr GLuint groups_per_row = 32768;  // of a dispatch: 65535 is all that is promised

void bind_storage(GLuint binding, const GlBuffer& buffer);

// Of a buffer, what a shader sees of it: OpenGL promises 16 MB.
std::size_t most_storage_bytes();

// What: who needs the buffer, and what for. Throws std::runtime_error where it would not fit.
GlBuffer make_storage(const std::string& what, std::size_t bytes);

// Groups of threads for so many groups of drops.
inline std::size_t thread_groups(std::size_t groups_of_drops) {
  constexpr std::size_t each = group_size / drops_of_group;
  return (groups_of_drops + each - 1) / each;
}

// Waits for what the shaders write, so that what follows, and the processor, may read it.
void dispatch_groups(const ShaderProgram& program, std::size_t groups);

// One number for each group, as a shader left them; and back, each as the sum of those before it,
// with the sum of all behind the last (so the buffer holds one more). Returns the sum of all.
std::vector<GLuint> read_counts(const GlBuffer& group_starts, std::size_t groups);
std::size_t write_starts(const GlBuffer& group_starts, std::vector<GLuint> counts);

// From here on what is drawn is behind surfaces and blended with what is there.
void begin_blending(const GlFramebuffer& target, int width, int height);

}  // namespace pluvia
