// The scene without rain: linear radiance at 2 x 2 samples a pixel, depth at pixel centres.
#pragma once

#include <glm/vec4.hpp>

#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/gpu_scene.h"

namespace pluvia {

constexpr int subpixels = 2;     // colour samples along each side of a pixel
constexpr double near_m = 0.01;  // surfaces nearer to the camera's plane are not drawn

struct SceneUniforms {  // scene_uniforms.glsl
  GpuCamera camera = {};
  glm::vec4 camera_m = {};
  glm::vec4 ambient = {};
  glm::vec4 sky = {};
};

struct ScenePass {
  Eigen::Vector3d origin_m = {0, 0, 0};  // of the vertices: floats near the camera are fine
  SceneUniforms values = {};
  int width = 0, height = 0, index_count = 0;
  GlBuffer uniforms = {}, positions = {}, normals = {}, indices = {};
  GlBuffer triangle_material = {}, materials = {}, lights = {};
  GlVertexArray vertices = {}, no_vertices = {};
  GlTexture sky_map = {};
  GlTexture color = {}, color_depth = {};  // subpixels times as wide and high
  GlTexture depth_m = {};                  // R32F; +inf where there is no surface
  GlTexture depth = {};                    // the same for depth tests: near_m / depth_m, reversed
  GlFramebuffer color_target = {}, depth_target = {};
  ShaderProgram surface = {}, surface_depth = {}, sky = {};
};

// environment_map: nullptr where the scene names none. Throws std::runtime_error for a picture that
// this OpenGL cannot hold.
ScenePass make_scene_pass(const Scene& scene, const Image* environment_map);

// The targets alone, for a picture in place of the surfaces (realtime/picture_pass.h): no program
// and no light; the vertices only where shadows are cast or parts move.
ScenePass make_scene_targets(const Scene& scene);

// Another map of the environment, of the size of the first; nothing for targets alone.
void set_sky(ScenePass& pass, const EnvironmentLight& environment, const Image& map);

// Uploads the vertices of the moving parts as scene.mesh has them now.
void move_vertices(const ScenePass& pass, const Scene& scene);

struct ShadowPass;

// Builds the programs that draw the surfaces, with shadows where there are any.
void link_scene_pass(ScenePass& pass, const ShadowPass& shadows);

// For scene.camera as it is now; the rest of the scene is the one the pass was made for.
void set_camera(ScenePass& pass, const Scene& scene, const ShadowPass& shadows);

void draw_scene(const ScenePass& pass, const ShadowPass& shadows);

// Colours alone, of another camera at the same place (its picture: size_px texels, `subpixels` of
// them to a pixel), into a square target with a depth of its own.
void draw_view(const ScenePass& pass, const ShadowPass& shadows, const GpuCamera& camera,
               const GlFramebuffer& target, int size_px);

PlannedPass plan_of(const ScenePass& pass);

}  // namespace pluvia
