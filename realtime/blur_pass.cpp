#include "realtime/blur_pass.h"

#include <cmath>
#include <vector>

#include "realtime/group_passes.h"
#include "realtime/shader.h"

namespace pluvia {
namespace {

constexpr int group_px = 8;
enum Binding : GLuint { weights_at, color_at = 0, across_at };

// A neighbour's weight is then below what a float of the sum shows.
constexpr double least_sigma_px = 0.17;

std::vector<float> blur_weights(double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(std::exp(-i * i / (2 * sigma_px * sigma_px)));
    sum += (i == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> shares;
  for (const double weight : weights) shares.push_back(static_cast<float>(weight / sum));
  return shares;
}

ShaderProgram blur_program(bool rows, std::size_t weights) {
  return build_program({"blur.comp"}, {{"COLOR", std::to_string(color_at)},
                                       {"ACROSS", std::to_string(across_at)},
                                       {"WEIGHTS", std::to_string(weights_at)},
                                       {"REACH", std::to_string(weights - 1)},
                                       {"ROWS", rows ? "1" : "0"},
                                       {"SUBPIXELS", std::to_string(subpixels)},
                                       {"GROUP_PX", std::to_string(group_px)}});
}

void run(const ShaderProgram& program, const ScenePass& surfaces) {
  const auto groups = [](int px) { return static_cast<GLuint>((px + group_px - 1) / group_px); };
  glUseProgram(program.id());
  glDispatchCompute(groups(surfaces.width), groups(surfaces.height), 1);
  glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                  GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace

BlurPass make_blur_pass(const Blur& blur, const ScenePass& surfaces) {
  const std::vector<float> weights = blur_weights(blur.sigma_px);
  return {.sigma_px = blur.sigma_px,
          .weights = make_buffer(weights),
          .across = make_texture(GL_RGBA32F, surfaces.width, surfaces.height),
          .rows = blur_program(true, weights.size()),
          .columns = blur_program(false, weights.size())};
}

std::string draw_blur(const BlurPass& pass, const ScenePass& surfaces) {
  if (pass.sigma_px < least_sigma_px) return "it is narrower than a pixel";
  glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  bind_storage(weights_at, pass.weights);
  glBindImageTexture(color_at, surfaces.color.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(across_at, pass.across.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  run(pass.rows, surfaces);
  run(pass.columns, surfaces);
  return "";
}

PlannedPass plan_of(const BlurPass& pass) {
  PlannedPass plan = {.name = "blur"};
  plan.add(pass.rows);
  plan.add(pass.columns);
  plan.add("weights", pass.weights);
  plan.add("blurred along rows", pass.across);
  return plan;
}

}  // namespace pluvia
