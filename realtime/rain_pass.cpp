#include "realtime/rain_pass.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "raytrace/drop_field.h"
#include "realtime/cumulative_atlas.h"
#include "realtime/rain_inputs.h"
#include "realtime/shader.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

constexpr int group_size = 256;           // drops of a compute group
constexpr int quads_per_instance = 1024;  // few instances: each costs a set-up, whatever it draws
constexpr int sums_width = 4096, sums_height = 1024;  // a layer of sums: 16 MB

enum Binding : GLuint {
  uniforms_at,
  group_starts_at,
  refused_at,
  streaks_at,
  lit_streaks_at,
  lights_at,
  atlas_lights_at,
  atlas_layers_at,
  atlas_views_at,
  atlas_spans_at,
  centres_at,
  top_height_at,
  sums_at
};

ShaderDefines defines() {
  ShaderDefines all = {{"GROUP_SIZE", std::to_string(group_size)},
                       {"QUADS_PER_INSTANCE", std::to_string(quads_per_instance)},
                       {"SUMS_WIDTH", std::to_string(sums_width)},
                       {"SUMS_HEIGHT", std::to_string(sums_height)},
                       {"NEAR_M", std::to_string(near_m)}};
  const std::pair<const char*, GLuint> bindings[] = {{"RAIN_UNIFORMS", uniforms_at},
                                                     {"GROUP_STARTS", group_starts_at},
                                                     {"REFUSED", refused_at},
                                                     {"STREAKS", streaks_at},
                                                     {"LIT_STREAKS", lit_streaks_at},
                                                     {"LIGHTS", lights_at},
                                                     {"ATLAS_LIGHTS", atlas_lights_at},
                                                     {"ATLAS_LAYERS", atlas_layers_at},
                                                     {"ATLAS_VIEWS", atlas_views_at},
                                                     {"ATLAS_SPANS", atlas_spans_at},
                                                     {"CENTRES", centres_at},
                                                     {"TOP_HEIGHT", top_height_at},
                                                     {"CUMULATIVE", sums_at}};
  for (const auto& [name, number] : bindings) all[name] = std::to_string(number);
  return all;
}

void bind_storage(GLuint binding, const GlBuffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.id());
}

void bind_inputs(const RainPass& pass) {
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniform_buffer.id());
  bind_storage(group_starts_at, pass.group_starts);
  bind_storage(refused_at, pass.refused);
  bind_storage(streaks_at, pass.streaks);
  bind_storage(lit_streaks_at, pass.lit_streaks);
  bind_storage(lights_at, pass.lights);
  bind_storage(atlas_lights_at, pass.atlas_lights);
  bind_storage(atlas_layers_at, pass.atlas_layers);
  bind_storage(atlas_views_at, pass.atlas_views);
  bind_storage(atlas_spans_at, pass.atlas_spans);
  glBindTextureUnit(top_height_at, pass.top_height.id());
  glBindTextureUnit(sums_at, pass.sums.id());
}

GlTexture upload_top_height(const TopHeight& top, double camera_z_m) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (std::max(top.width, top.height) > largest)
    throw std::runtime_error(
        fmt::format("top height: {} x {} texels; expected at most {} a side on "
                    "this OpenGL",
                    top.width, top.height, largest));
  std::vector<float> from_camera;
  for (const float z : top.z_m)
    from_camera.push_back(static_cast<float>(static_cast<double>(z) - camera_z_m));
  GlTexture texture = make_texture(GL_R32F, top.width, top.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.id(), 0, 0, 0, top.width, top.height, GL_RED, GL_FLOAT,
                      from_camera.data());
  return texture;
}

// One long array, folded into layers: a storage buffer may be limited to 128 MB.
GlTexture upload_sums(std::vector<float>& sums) {
  constexpr std::size_t layer = std::size_t{sums_width} * sums_height;
  const std::size_t layers = (sums.size() + layer - 1) / layer;
  const auto rows = layers > 1 ? sums_height : (sums.size() + sums_width - 1) / sums_width;
  sums.resize(layers * rows * sums_width);
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  glTextureStorage3D(id, 1, GL_R32F, sums_width, static_cast<GLsizei>(rows),
                     static_cast<GLsizei>(layers));
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(id, 0, 0, 0, 0, sums_width, static_cast<GLsizei>(rows),
                      static_cast<GLsizei>(layers), GL_RED, GL_FLOAT, sums.data());
  return texture;
}

GlVertexArray make_quads(GlBuffer& indices) {
  std::vector<GLuint> values;
  for (GLuint quad = 0; quad < quads_per_instance; ++quad) {
    for (const GLuint corner : {0u, 1u, 2u, 2u, 1u, 3u}) values.push_back(4 * quad + corner);
  }
  indices = make_buffer(values);
  GlVertexArray quads = make_vertex_array();
  glVertexArrayElementBuffer(quads.id(), indices.id());
  return quads;
}

void set_time(RainPass& pass, double time_s) {
  const FallState fall = fall_state(pass.rain, time_s);
  pass.uniforms.fall.x = fall.phase;
  pass.uniforms.fall.y = fall.round;
}

void upload_uniforms(const RainPass& pass) {
  glNamedBufferSubData(pass.uniform_buffer.id(), 0, sizeof(pass.uniforms), &pass.uniforms);
}

GLuint group_count(const RainPass& pass) {
  return static_cast<GLuint>((pass.uniforms.counts.x + group_size - 1) / group_size);
}

// Exclusive sums of the groups' counts, put back for the placing shader; returns the total.
std::size_t sum_groups(const RainPass& pass) {
  std::vector<GLuint> groups(group_count(pass));
  const auto bytes = static_cast<GLsizeiptr>(groups.size() * sizeof(GLuint));
  glGetNamedBufferSubData(pass.group_starts.id(), 0, bytes, groups.data());
  const std::size_t total = std::accumulate(groups.begin(), groups.end(), std::size_t{0});
  std::exclusive_scan(groups.begin(), groups.end(), groups.begin(), GLuint{0});
  glNamedBufferSubData(pass.group_starts.id(), 0, bytes, groups.data());
  return total;
}

void reserve_records(RainPass& pass, std::size_t streaks) {
  if (streaks <= pass.capacity) return;
  const std::size_t capacity = streaks + streaks / 4;  // the next frames may show a few more
  const auto lights = static_cast<std::size_t>(pass.uniforms.counts.y);
  const std::size_t bytes =
      capacity * std::max(sizeof(StreakRecord), lights * sizeof(LitStreakRecord));
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  if (bytes > static_cast<std::size_t>(largest))
    throw std::runtime_error(fmt::format(
        "rain: {} drops in view with {} lights need {} bytes; expected at most {} on this OpenGL",
        streaks, lights, bytes, largest));
  pass.streaks = make_buffer(nullptr, capacity * sizeof(StreakRecord));
  pass.lit_streaks = make_buffer(nullptr, capacity * lights * sizeof(LitStreakRecord));
  pass.capacity = capacity;
}

void dispatch(const RainPass& pass, const GlProgram& program) {
  bind_inputs(pass);
  glUseProgram(program.id());
  glDispatchCompute(group_count(pass), 1, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void refuse_light_inside_drop(const RainPass& pass) {
  GLuint refused = 0;
  glGetNamedBufferSubData(pass.refused.id(), 0, sizeof(refused), &refused);
  if (refused)
    throw std::runtime_error(
        fmt::format("scene: a light is inside a drop's path; expected more than "
                    "the drop's radius, {} m, between them",
                    pass.rain.mean_radius_m));
}

}  // namespace

RainPass make_rain_pass(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options,
                        const glm::vec4& environment) {
  check_rain_inputs(scene, atlas, options);
  const TopHeight top = top_height(scene.mesh, scene.rain, TopHeight{}.texel_m);
  RainPass pass;
  pass.rain = scene.rain;
  pass.uniforms = rain_uniforms(scene, atlas, options, top);
  // w tells the shader whether there is anything to look up.
  const bool lit = environment.x > 0 || environment.y > 0 || environment.z > 0;
  pass.uniforms.environment = {environment.x, environment.y, environment.z, lit ? 1.0f : 0.0f};
  CumulativeAtlas cumulative = cumulative_atlas(
      atlas, {.finest = pass.uniforms.sizes.y, .coarsest = pass.uniforms.sizes.z}, lit);
  pass.sums = upload_sums(cumulative.sums);
  pass.sums_bytes = cumulative.sums.size() * sizeof(float);
  pass.top_height = upload_top_height(top, scene.camera.position_m.z());
  pass.uniform_buffer = make_buffer(&pass.uniforms, sizeof(pass.uniforms));
  pass.group_starts = make_buffer(std::vector<GLuint>(group_count(pass)));
  pass.refused = make_buffer(nullptr, 0);
  pass.lights = make_buffer(gpu_lights(scene));
  pass.atlas_lights = make_buffer(atlas_light_directions(atlas));
  pass.atlas_layers = make_buffer(mirrored_layers(atlas));
  pass.atlas_views = make_buffer(atlas_views(atlas));
  pass.atlas_spans = make_buffer(cumulative.spans);
  pass.quads = make_quads(pass.quad_indices);
  pass.count = build_program({"rain_count.comp"}, defines());
  pass.place = build_program({"rain_place.comp"}, defines());
  pass.draw = build_program({"rain.vert", "rain.frag"}, defines());
  return pass;
}

long place_rain(RainPass& pass, double time_s) {
  set_time(pass, time_s);
  upload_uniforms(pass);
  dispatch(pass, pass.count);
  const std::size_t streaks = sum_groups(pass);
  reserve_records(pass, streaks);
  pass.uniforms.sizes.w = static_cast<int>(streaks);
  upload_uniforms(pass);
  if (streaks == 0) return 0;
  dispatch(pass, pass.place);
  refuse_light_inside_drop(pass);
  return static_cast<long>(streaks);
}

void draw_rain(const RainPass& pass, const GlFramebuffer& target) {
  const float dry[4] = {0, 0, 0, 0};
  glClearNamedFramebufferfv(target.id(), GL_COLOR, 0, dry);
  if (pass.uniforms.sizes.w == 0) return;
  bind_inputs(pass);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.id());
  glViewport(0, 0, static_cast<int>(pass.uniforms.camera.up.w),
             static_cast<int>(pass.uniforms.camera.forward.w));
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glDisable(GL_CULL_FACE);
  glUseProgram(pass.draw.id());
  glBindVertexArray(pass.quads.id());
  const int instances = (pass.uniforms.sizes.w + quads_per_instance - 1) / quads_per_instance;
  glDrawElementsInstanced(GL_TRIANGLES, 6 * quads_per_instance, GL_UNSIGNED_INT, nullptr,
                          instances);
}

StreakRecords read_records(const RainPass& pass) {
  StreakRecords records;
  const auto streaks = static_cast<std::size_t>(pass.uniforms.sizes.w);
  records.streaks.resize(streaks);
  records.lit.resize(streaks * static_cast<std::size_t>(pass.uniforms.counts.y));
  if (streaks == 0) return records;
  glGetNamedBufferSubData(pass.streaks.id(), 0,
                          static_cast<GLsizeiptr>(streaks * sizeof(StreakRecord)),
                          records.streaks.data());
  if (!records.lit.empty())
    glGetNamedBufferSubData(pass.lit_streaks.id(), 0,
                            static_cast<GLsizeiptr>(records.lit.size() * sizeof(LitStreakRecord)),
                            records.lit.data());
  return records;
}

std::vector<float> read_centres_m(RainPass& pass, double time_s) {
  if (pass.centres.id() == 0) pass.centres = build_program({"rain_centres.comp"}, defines());
  std::vector<float> centres(3 * static_cast<std::size_t>(pass.uniforms.counts.x));
  const GlBuffer buffer = make_buffer(centres);
  set_time(pass, time_s);
  upload_uniforms(pass);
  bind_storage(centres_at, buffer);
  dispatch(pass, pass.centres);
  glGetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(centres.size() * sizeof(float)),
                          centres.data());
  return centres;
}

}  // namespace pluvia
