#include "realtime/darkening_pass.h"

#include <fmt/format.h>

#include "atlas/rec709.h"
#include "realtime/shader.h"

namespace pluvia {
namespace {

constexpr int group_px = 8;
enum Binding : GLuint { color_at };

}  // namespace

DarkeningPass make_darkening_pass(const Darkening& darkening) {
  const auto& y = rec709_luminance;
  return {darkening,
          build_program({"darkening.comp"},
                        {{"COLOR", std::to_string(color_at)},
                         {"GROUP_PX", std::to_string(group_px)},
                         {"LUMINANCE", fmt::format("vec3({}, {}, {})", y[0], y[1], y[2])},
                         {"DESATURATION", fmt::format("{:.9e}", darkening.desaturation)},
                         {"BRIGHTNESS", fmt::format("{:.9e}", darkening.brightness)}})};
}

std::string draw_darkening(const DarkeningPass& pass, const ScenePass& surfaces) {
  if (pass.values.desaturation == 0 && pass.values.brightness == 1)
    return "it leaves colours alone";
  glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  glBindImageTexture(color_at, surfaces.color.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glUseProgram(pass.program.id());
  const auto groups = [](int px) {
    return static_cast<GLuint>((subpixels * px + group_px - 1) / group_px);
  };
  glDispatchCompute(groups(surfaces.width), groups(surfaces.height), 1);
  glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                  GL_FRAMEBUFFER_BARRIER_BIT);
  return "";
}

PlannedPass plan_of(const DarkeningPass& pass) {
  PlannedPass plan = {.name = "darkening"};
  plan.add(pass.program);
  return plan;
}

}  // namespace pluvia
