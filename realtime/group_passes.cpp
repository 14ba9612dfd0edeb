#include "realtime/group_passes.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

void bind_storage(GLuint binding, const GlBuffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.id());
}

std::size_t most_storage_bytes() {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  return static_cast<std::size_t>(most);
}

GlBuffer make_storage(const std::string& what, std::size_t bytes) {
  if (bytes > most_storage_bytes())
    throw std::runtime_error(fmt::format("{} need {} bytes; expected at most {} on this OpenGL",
                                         what, bytes, most_storage_bytes()));
  return make_buffer(nullptr, bytes);
}

void dispatch_groups(const ShaderProgram& program, std::size_t groups) {
  const auto all = static_cast<GLuint>(groups);
  glUseProgram(program.id());
  glDispatchCompute(std::min(all, groups_per_row), (all + groups_per_row - 1) / groups_per_row, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

std::vector<GLuint> read_counts(const GlBuffer& group_starts, std::size_t groups) {
  std::vector<GLuint> counts(groups);
  glGetNamedBufferSubData(group_starts.id(), 0, static_cast<GLsizeiptr>(groups * sizeof(GLuint)),
                          counts.data());
  return counts;
}

std::size_t write_starts(const GlBuffer& group_starts, std::vector<GLuint> counts) {
  const std::size_t total = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  counts.push_back(0);
  std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), GLuint{0});
  update_buffer(group_starts, counts);
  return total;
}

void begin_blending(const GlFramebuffer& target, int width, int height) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.id());
  glViewport(0, 0, width, height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

}  // namespace pluvia
