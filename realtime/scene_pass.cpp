#include "realtime/scene_pass.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "raytrace/moving_parts.h"
#include "realtime/shader.h"
#include "realtime/shadow_pass.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

enum Binding : GLuint {
  uniforms_at,
  materials_at,
  triangle_material_at,
  lights_at,
  sky_map_at,
  shadow_views_at,
  shadow_maps_at
};

ShaderDefines defines(const ShadowPass& shadows) {
  return {{"SHADOWS", shadows.empty() ? "0" : "1"},
          {"SHADOW_VIEWS", std::to_string(shadow_views_at)},
          {"SHADOW_MAPS", std::to_string(shadow_maps_at)},
          {"SCENE_UNIFORMS", std::to_string(uniforms_at)},
          {"MATERIALS", std::to_string(materials_at)},
          {"TRIANGLE_MATERIAL", std::to_string(triangle_material_at)},
          {"LIGHTS", std::to_string(lights_at)},
          {"SKY_MAP", std::to_string(sky_map_at)},
          {"SUBPIXELS", std::to_string(subpixels)},
          {"NEAR_M", std::to_string(near_m)}};
}

struct GpuMaterial {
  glm::vec4 base_color = {};
  glm::vec4 emission_cd_m2 = {};
};

GlBuffer upload_materials(const Mesh& mesh) {
  std::vector<GpuMaterial> materials;
  for (const Material& material : mesh.materials)
    materials.push_back({to_glm(material.base_color, 1), to_glm(material.emission_cd_m2, 0)});
  return make_buffer(materials);
}

// From the pass's origin, in double: a scene far from the world's origin is as good as near it.
std::vector<glm::vec3> gpu_positions(const ScenePass& pass, const Mesh& mesh, std::size_t first) {
  std::vector<glm::vec3> positions;
  for (std::size_t i = first; i < mesh.positions_m.size(); ++i)
    positions.push_back(to_glm(mesh.positions_m[i].cast<double>() - pass.origin_m));
  return positions;
}

void upload_mesh(ScenePass& pass, const Scene& scene) {
  pass.index_count = static_cast<int>(scene.mesh.indices.size());
  pass.positions = make_buffer(gpu_positions(pass, scene.mesh, 0));
  pass.normals = make_buffer(scene.mesh.normals);
  pass.indices = make_buffer(scene.mesh.indices);
  pass.triangle_material = make_buffer(scene.mesh.triangle_material);
  pass.materials = upload_materials(scene.mesh);
  pass.vertices = make_vertex_array();
  const GLuint array = pass.vertices.id();
  const GLuint sources[] = {pass.positions.id(), pass.normals.id()};
  for (GLuint i = 0; i < 2; ++i) {
    glVertexArrayVertexBuffer(array, i, sources[i], 0, 3 * sizeof(float));
    glVertexArrayAttribFormat(array, i, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array, i, i);
    glEnableVertexArrayAttrib(array, i);
  }
  glVertexArrayElementBuffer(array, pass.indices.id());
}

void update_sky(const GlTexture& texture, const Image& map) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.id(), 0, 0, 0, map.width, map.height, GL_RGB, GL_FLOAT,
                      map.values.data());
}

GlTexture upload_sky(const Image* map) {
  if (!map) return make_texture(GL_RGB32F, 1, 1);
  GlTexture texture = make_texture(GL_RGB32F, map->width, map->height);
  update_sky(texture, *map);
  glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  return texture;
}

void check_size(const char* what, int size, int factor) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (size > largest / factor)
    throw std::runtime_error(fmt::format("scene: {} = {} px; expected at most {} px on this OpenGL",
                                         what, size, largest / factor));
}

void make_targets(ScenePass& pass) {
  const int wide = pass.width * subpixels, high = pass.height * subpixels;
  pass.color = make_texture(GL_RGBA32F, wide, high);
  pass.color_depth = make_texture(GL_DEPTH_COMPONENT32F, wide, high);
  pass.depth_m = make_texture(GL_R32F, pass.width, pass.height);
  pass.depth = make_texture(GL_DEPTH_COMPONENT32F, pass.width, pass.height);
  pass.color_target = make_framebuffer({pass.color.id()}, pass.color_depth.id());
  pass.depth_target = make_framebuffer({pass.depth_m.id()}, pass.depth.id());
}

ScenePass sized_pass(const Scene& scene) {
  check_size("camera.width_px", scene.camera.width_px, subpixels);
  check_size("camera.height_px", scene.camera.height_px, subpixels);
  ScenePass pass;
  pass.width = scene.camera.width_px;
  pass.height = scene.camera.height_px;
  make_targets(pass);
  pass.origin_m = scene.camera.position_m;
  return pass;
}

SceneUniforms scene_uniforms(const Scene& scene, const Image* map) {
  SceneUniforms uniforms;
  uniforms.camera = gpu_camera(scene.camera);
  uniforms.ambient = mean_environment(scene.environment, map);
  uniforms.ambient.w = map ? 1.0f : 0.0f;
  uniforms.sky = map ? glm::vec4(static_cast<float>(scene.environment.scale_cd_m2))
                     : to_glm(scene.environment.uniform_cd_m2, 0);
  uniforms.sky.w = static_cast<float>(scene.lights.size());
  return uniforms;
}

void bind_inputs(const ScenePass& pass) {
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniforms.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, materials_at, pass.materials.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, triangle_material_at, pass.triangle_material.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, lights_at, pass.lights.id());
  glBindTextureUnit(sky_map_at, pass.sky_map.id());
}

void clear_depth(const GlFramebuffer& target) {
  const float infinitely_far = 0;
  glClearNamedFramebufferfv(target.id(), GL_DEPTH, 0, &infinitely_far);
}

void draw_surfaces(const ScenePass& pass, const ShaderProgram& program) {
  if (pass.index_count == 0) return;
  glEnable(GL_DEPTH_TEST);
  glUseProgram(program.id());
  glBindVertexArray(pass.vertices.id());
  glDrawElements(GL_TRIANGLES, pass.index_count, GL_UNSIGNED_INT, nullptr);
}

void begin_surfaces(const ScenePass& pass, const ShadowPass& shadows) {
  bind_inputs(pass);
  if (!shadows.empty()) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, shadow_views_at, shadows.view_buffer.id());
    glBindTextureUnit(shadow_maps_at, shadows.maps.id());
  }
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

void draw_colors(const ScenePass& pass, const GlFramebuffer& target, int wide, int high) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.id());
  glViewport(0, 0, wide, high);
  clear_depth(target);
  glDisable(GL_DEPTH_TEST);
  glUseProgram(pass.sky.id());
  glBindVertexArray(pass.no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  draw_surfaces(pass, pass.surface);
}

void upload_values(const ScenePass& pass, const SceneUniforms& values) {
  glNamedBufferSubData(pass.uniforms.id(), 0, sizeof(values), &values);
}

}  // namespace

ScenePass make_scene_targets(const Scene& scene) {
  ScenePass pass = sized_pass(scene);
  const bool shadows = std::any_of(scene.lights.begin(), scene.lights.end(),
                                   [](const Light& light) { return light.shadow; });
  if (shadows || !scene.moving.empty()) upload_mesh(pass, scene);
  return pass;
}

ScenePass make_scene_pass(const Scene& scene, const Image* environment_map) {
  if (environment_map) check_size("width of environment.map", environment_map->width, 1);
  ScenePass pass = sized_pass(scene);
  upload_mesh(pass, scene);
  pass.values = scene_uniforms(scene, environment_map);
  pass.uniforms = make_buffer(&pass.values, sizeof(pass.values));
  pass.lights = make_buffer(gpu_lights(scene, {}));
  pass.no_vertices = make_vertex_array();
  pass.sky_map = upload_sky(environment_map);
  return pass;
}

void set_sky(ScenePass& pass, const EnvironmentLight& environment, const Image& map) {
  if (pass.sky_map.id() == 0) return;
  pass.values.ambient = glm::vec4(glm::vec3(mean_environment(environment, &map)), 1);
  update_sky(pass.sky_map, map);
}

void move_vertices(const ScenePass& pass, const Scene& scene) {
  const std::size_t first = resting_vertices(scene);
  update_values(pass.positions, first, gpu_positions(pass, scene.mesh, first));
  const auto& normals = scene.mesh.normals;
  update_values(pass.normals, first,
                std::vector<Eigen::Vector3f>(normals.begin() + static_cast<std::ptrdiff_t>(first),
                                             normals.end()));
}

void link_scene_pass(ScenePass& pass, const ShadowPass& shadows) {
  pass.surface = build_program({"scene.vert", "scene.frag"}, defines(shadows));
  pass.surface_depth = build_program({"scene.vert", "scene_depth.frag"}, defines(shadows));
  pass.sky = build_program({"screen.vert", "sky.frag"}, defines(shadows));
}

void set_camera(ScenePass& pass, const Scene& scene, const ShadowPass& shadows) {
  pass.values.camera = gpu_camera(scene.camera);
  pass.values.camera_m = to_glm(scene.camera.position_m - pass.origin_m, 0);
  upload_values(pass, pass.values);
  update_buffer(pass.lights, gpu_lights(scene, shadows.slots));
}

void draw_scene(const ScenePass& pass, const ShadowPass& shadows) {
  begin_surfaces(pass, shadows);
  draw_colors(pass, pass.color_target, subpixels * pass.width, subpixels * pass.height);

  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, pass.depth_target.id());
  glViewport(0, 0, pass.width, pass.height);
  clear_depth(pass.depth_target);
  const float nothing[4] = {std::numeric_limits<float>::infinity(), 0, 0, 0};
  glClearNamedFramebufferfv(pass.depth_target.id(), GL_COLOR, 0, nothing);
  draw_surfaces(pass, pass.surface_depth);
}

void draw_view(const ScenePass& pass, const ShadowPass& shadows, const GpuCamera& camera,
               const GlFramebuffer& target, int size_px) {
  SceneUniforms values = pass.values;
  values.camera = camera;
  upload_values(pass, values);
  begin_surfaces(pass, shadows);
  draw_colors(pass, target, size_px, size_px);
  upload_values(pass, pass.values);
}

PlannedPass plan_of(const ScenePass& pass) {
  PlannedPass plan = {.name = "surfaces"};
  for (const ShaderProgram* program : {&pass.surface, &pass.surface_depth, &pass.sky})
    plan.add(*program);
  plan.add("uniforms", pass.uniforms);
  plan.add("positions", pass.positions);
  plan.add("normals", pass.normals);
  plan.add("indices", pass.indices);
  plan.add("materials of triangles", pass.triangle_material);
  plan.add("materials", pass.materials);
  plan.add("lights", pass.lights);
  plan.add("sky", pass.sky_map);
  plan.add("colour, 2 x 2 a pixel", pass.color);
  plan.add("depth, 2 x 2 a pixel", pass.color_depth);
  plan.add("distance", pass.depth_m);
  plan.add("depth", pass.depth);
  return plan;
}

}  // namespace pluvia
