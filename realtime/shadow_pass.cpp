#include "realtime/shadow_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "raytrace/fall_frame.h"
#include "raytrace/moving_parts.h"
#include "realtime/shader.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

constexpr int few_maps = 4, few_px = 4096, many_px = 1024;  // 256 MB of few, 4 MB for each of many
constexpr double least_distance_m = 0.02;  // from a lamp: nearer surfaces are the lamp's own
constexpr double widest_spot_deg = 60;     // half-angle; a wider one takes the faces of a cube

// Rows of a matrix that GLSL multiplies from the left; GLM stores columns.
glm::mat4 from_rows(const std::array<glm::vec4, 4>& rows) {
  glm::mat4 matrix;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) matrix[c][r] = rows[static_cast<std::size_t>(r)][c];
  }
  return matrix;
}

glm::vec4 row(const Eigen::Vector3d& axis, double scale, const Eigen::Vector3d& origin,
              double offset = 0) {
  return to_glm(scale * axis, offset - scale * axis.dot(origin));
}

// A picture from `place` along `forward`, tan(half angle) = spread to each side.
glm::mat4 perspective(const Eigen::Vector3d& place, const Eigen::Vector3d& forward, double spread) {
  const FallFrame frame = fall_frame(-forward);  // any frame whose z is forward
  return from_rows({row(frame.x, 1 / spread, place), row(frame.y, 1 / spread, place),
                    glm::vec4(0, 0, 0, least_distance_m), row(frame.z, 1, place)});
}

struct Ball {
  Eigen::Vector3d centre_m = {0, 0, 0};
  double radius_m = 1;
};

// Around all surfaces, at all times.
Ball ball_around(const Scene& scene) {
  const Bounds all = surface_bounds(scene);
  return {(all.low_m + all.high_m) / 2, std::max((all.high_m - all.low_m).norm() / 2, 1e-3)};
}

glm::mat4 parallel(const Ball& ball, const Eigen::Vector3d& forward,
                   const Eigen::Vector3d& origin_m) {
  const FallFrame frame = fall_frame(-forward);
  const Eigen::Vector3d centre = ball.centre_m - origin_m;
  // Nearest 1, farthest 0.
  return from_rows({row(frame.x, 1 / ball.radius_m, centre),
                    row(frame.y, 1 / ball.radius_m, centre),
                    row(frame.z, -0.5 / ball.radius_m, centre, 0.5), glm::vec4(0, 0, 0, 1)});
}

bool is_narrow(const Light& light) {
  return light.kind == LightKind::spot && light.outer_half_angle_deg <= widest_spot_deg;
}

// Half of what a map spans, at 1 m from the light or, for the sun, in m. A little more than the
// light needs: the four texels around a point at its rim are there.
double half_span(const Light& light, const Ball& ball) {
  if (light.kind == LightKind::sun) return ball.radius_m;
  if (!is_narrow(light)) return 1.01;
  return 1.02 * std::tan(light.outer_half_angle_deg * std::numbers::pi / 180);
}

std::vector<glm::mat4> views_of(const Light& light, const Ball& ball,
                                const Eigen::Vector3d& origin_m) {
  if (light.kind == LightKind::sun) return {parallel(ball, light.direction, origin_m)};
  const Eigen::Vector3d place = light.position_m - origin_m;
  const double spread = half_span(light, ball);
  if (is_narrow(light)) return {perspective(place, light.direction, spread)};
  std::vector<glm::mat4> faces;  // in the order in which shadows.glsl numbers them
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0})
      faces.push_back(perspective(place, sign * Eigen::Vector3d::Unit(axis), spread));
  }
  return faces;
}

int size_px(std::size_t count) {
  return count <= few_maps ? few_px : many_px;
}

GlTexture make_maps(std::size_t count) {
  const int map_px = size_px(count);
  GLint layers = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
  if (count > static_cast<std::size_t>(layers))
    throw std::runtime_error(fmt::format(
        "scene: shadows need {} maps; expected at most {} on this OpenGL", count, layers));
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture maps(id);
  glTextureStorage3D(id, 1, GL_DEPTH_COMPONENT32F, map_px, map_px, static_cast<GLsizei>(count));
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(id, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  return maps;
}

}  // namespace

ShadowPass make_shadow_pass(const Scene& scene, const ScenePass& surfaces) {
  ShadowPass pass;
  const bool any_surface = !scene.mesh.indices.empty();
  const Ball ball = any_surface ? ball_around(scene) : Ball();
  for (const Light& light : scene.lights) {
    pass.slots.emplace_back();
    if (!light.shadow || !any_surface) continue;
    const std::vector<glm::mat4> views = views_of(light, ball, surfaces.origin_m);
    pass.slots.back() = {static_cast<int>(pass.views.size()), static_cast<int>(views.size()), 0};
    pass.views.insert(pass.views.end(), views.begin(), views.end());
  }
  if (pass.views.empty()) return pass;
  pass.maps = make_maps(pass.views.size());
  pass.view_buffer = make_buffer(pass.views);
  const auto map_px = static_cast<std::size_t>(size_px(pass.views.size()));
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    pass.slots[i].texel = 2 * half_span(scene.lights[i], ball) / static_cast<double>(map_px);
  pass.program = build_program({"shadow.vert", "shadow.frag"}, {});
  draw_shadow_maps(pass, surfaces);
  return pass;
}

void draw_shadow_maps(const ShadowPass& pass, const ScenePass& surfaces) {
  if (pass.empty()) return;
  const int map_px = size_px(pass.views.size());
  GLuint target_id = 0;
  glCreateFramebuffers(1, &target_id);
  const GlFramebuffer target(target_id);
  glNamedFramebufferDrawBuffer(target_id, GL_NONE);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glViewport(0, 0, map_px, map_px);
  glUseProgram(pass.program.id());
  glBindVertexArray(surfaces.vertices.id());
  const float infinitely_far = 0;
  for (std::size_t i = 0; i < pass.views.size(); ++i) {
    glNamedFramebufferTextureLayer(target_id, GL_DEPTH_ATTACHMENT, pass.maps.id(), 0,
                                   static_cast<GLint>(i));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target_id);
    glClearNamedFramebufferfv(target_id, GL_DEPTH, 0, &infinitely_far);
    glUniformMatrix4fv(0, 1, GL_FALSE, &pass.views[i][0][0]);
    if (surfaces.index_count > 0)
      glDrawElements(GL_TRIANGLES, surfaces.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

PlannedPass plan_of(const ShadowPass& pass) {
  PlannedPass plan = {.name = "shadows"};
  plan.add(pass.program);
  plan.add("maps", pass.maps);
  plan.add("views", pass.view_buffer);
  return plan;
}

}  // namespace pluvia
