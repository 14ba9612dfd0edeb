#include "realtime/frame_plan.h"

#include <algorithm>
#include <array>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "atlas/json_place.h"

namespace pluvia {
namespace {

std::size_t buffer_bytes(const GlBuffer& buffer) {
  GLint64 bytes = 0;
  glGetNamedBufferParameteri64v(buffer.id(), GL_BUFFER_SIZE, &bytes);
  return static_cast<std::size_t>(bytes);
}

std::size_t texture_bytes(const GlTexture& texture) {
  GLint levels = 0, target = 0;
  glGetTextureParameteriv(texture.id(), GL_TEXTURE_IMMUTABLE_LEVELS, &levels);
  glGetTextureParameteriv(texture.id(), GL_TEXTURE_TARGET, &target);
  GLint level = 0;
  const auto value = [&](GLenum name) {
    GLint result = 0;
    glGetTextureLevelParameteriv(texture.id(), level, name, &result);
    return static_cast<std::size_t>(result);
  };
  constexpr std::array<GLenum, 5> channels = {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE,
                                              GL_TEXTURE_BLUE_SIZE, GL_TEXTURE_ALPHA_SIZE,
                                              GL_TEXTURE_DEPTH_SIZE};
  const std::size_t bits =
      std::accumulate(channels.begin(), channels.end(), std::size_t{0},
                      [&](std::size_t sum, GLenum channel) { return sum + value(channel); });
  std::size_t texels = 0;
  for (; level < levels; ++level)
    texels += value(GL_TEXTURE_WIDTH) * value(GL_TEXTURE_HEIGHT) * value(GL_TEXTURE_DEPTH);
  const std::size_t faces = target == GL_TEXTURE_CUBE_MAP ? 6 : 1;  // its depth is of one face
  return faces * texels * bits / 8;
}

}  // namespace

void PlannedPass::add(const ShaderProgram& program) {
  for (const std::string& file : program.files) {
    if (std::find(shaders.begin(), shaders.end(), file) == shaders.end()) shaders.push_back(file);
  }
}

void PlannedPass::add(const std::string& resource, const GlBuffer& buffer) {
  if (buffer.id() != 0) resources.push_back({resource, buffer_bytes(buffer)});
}

void PlannedPass::add(const std::string& resource, const GlTexture& texture) {
  if (texture.id() != 0) resources.push_back({resource, texture_bytes(texture)});
}

std::size_t bytes_of(const PlannedPass& pass) {
  return std::accumulate(
      pass.resources.begin(), pass.resources.end(), std::size_t{0},
      [](std::size_t sum, const PlannedResource& resource) { return sum + resource.bytes; });
}

std::string plan_text(const FramePlan& plan) {
  std::string text;
  std::size_t all = 0;
  for (const PlannedPass& pass : plan.passes) {
    all += bytes_of(pass);
    text += fmt::format("{:<12} {:>12} bytes  shaders {}\n", pass.name, bytes_of(pass),
                        fmt::join(pass.shaders, ", "));
    for (const std::string& note : pass.notes) text += fmt::format("  {}\n", note);
    for (const PlannedResource& resource : pass.resources)
      text += fmt::format("  {:<28} {:>12}\n", resource.name, resource.bytes);
  }
  return text + fmt::format("{:<12} {:>12} bytes\n", "all", all);
}

std::string costs_json(const FramePlan& plan, const std::vector<std::vector<PassCost>>& frames) {
  nlohmann::ordered_json json = {{"version", 1}};
  for (const PlannedPass& pass : plan.passes) {
    nlohmann::ordered_json resources = nlohmann::ordered_json::array();
    for (const PlannedResource& resource : pass.resources)
      resources.push_back({{"name", resource.name}, {"bytes", resource.bytes}});
    json["plan"].push_back({{"pass", pass.name},
                            {"bytes", bytes_of(pass)},
                            {"shaders", pass.shaders},
                            {"resources", resources}});
    if (!pass.notes.empty()) json["plan"].back()["notes"] = pass.notes;
  }
  json["frames"] = nlohmann::ordered_json::array();
  for (const std::vector<PassCost>& frame : frames) {
    nlohmann::ordered_json costs = nlohmann::ordered_json::array();
    for (const PassCost& cost : frame) {
      nlohmann::ordered_json entry = {
          {"pass", cost.pass}, {"wall_s", cost.wall_s}, {"cpu_s", cost.cpu_s}};
      if (!cost.skipped.empty()) entry["skipped"] = cost.skipped;
      costs.push_back(entry);
    }
    json["frames"].push_back(costs);
  }
  return document_text(json, 1);
}

}  // namespace pluvia
