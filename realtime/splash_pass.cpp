#include "realtime/splash_pass.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "oscillation/fall_speed.h"
#include "raytrace/droplet_light.h"
#include "realtime/group_passes.h"
#include "realtime/rain_bindings.h"
#include "realtime/rain_inputs.h"
#include "realtime/shader.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

constexpr int phase_bins = 360;

enum Binding : GLuint {
  rain_uniforms_at,
  uniforms_at,
  sizes_at,
  splash_sizes_at,
  parts_at,
  groups_at,
  group_starts_at,
  hits_at,
  strokes_at,
  lights_at,
  top_heights_at,
  densities_at,
  phase_at,
  shadow_views_at,
  shadow_maps_at,
  moving_drops_at
};

ShaderDefines defines(bool place, const RainPass& rain, const ShadowPass& shadows) {
  ShaderDefines all = {{"PLACE", place ? "1" : "0"},
                       {"SHADOWS", place && !shadows.empty() ? "1" : "0"},
                       {"MOVING_DROPS", std::to_string(moving_drops_at)},
                       {"GROUP_SIZE", std::to_string(group_size)},
                       {"DROPS_OF_GROUP", std::to_string(group_size)},
                       {"GROUPS_PER_ROW", std::to_string(groups_per_row)},
                       {"NEAR_M", std::to_string(near_m)},
                       {"SPLASH_VARIANTS", std::to_string(splash_variants)},
                       {"CROWN_BEADS", std::to_string(crown_beads)},
                       {"MOST_DROPLETS", std::to_string(most_splash_droplets)},
                       {"SPLASH_DRIFT", std::to_string(splash_drift)},
                       {"RAIN_UNIFORMS", std::to_string(rain_uniforms_at)},
                       {"SPLASH_UNIFORMS", std::to_string(uniforms_at)},
                       {"RAIN_SIZES", std::to_string(sizes_at)},
                       {"SPLASH_SIZES", std::to_string(splash_sizes_at)},
                       {"SPLASH_PARTS", std::to_string(parts_at)},
                       {"DROP_GROUPS", std::to_string(groups_at)},
                       {"GROUP_STARTS", std::to_string(group_starts_at)},
                       {"HITS", std::to_string(hits_at)},
                       {"STROKES", std::to_string(strokes_at)},
                       {"LIGHTS", std::to_string(lights_at)},
                       {"TOP_HEIGHTS", std::to_string(top_heights_at)},
                       {"DENSITIES", std::to_string(densities_at)},
                       {"PHASE", std::to_string(phase_at)},
                       {"SHADOW_VIEWS", std::to_string(shadow_views_at)},
                       {"SHADOW_MAPS", std::to_string(shadow_maps_at)}};
  all.merge(drop_defines(rain));
  return all;
}

void add_groups(SplashPass& pass, const GpuDropGroup& group, std::uint32_t drops) {
  add_split(group, drops, group_size, pass.groups);
}

// The drops of a slab's cells that may splash in view: a size of its own for the shader.
void add_slab(SplashPass& pass, const Scene& scene, const RainPass& rain, const SplashSlab& slab) {
  const auto index = static_cast<std::size_t>(slab.size);
  const auto number = static_cast<int>(pass.sizes.size());
  GpuRainSize gpu = rain.sizes[index];
  gpu.run = {slab.local.phase, slab.local.round, 1, 0};
  pass.sizes.push_back(gpu);
  pass.slab_sizes.push_back(pass.splash_sizes[index]);
  for (const RainCell& cell : splash_cells(scene, *pass.space, pass.splashes, slab)) {
    GpuDropGroup group =
        cell_group(*pass.space, slab.size, slab.local.floor_m, cell, scene.camera.position_m);
    group.what.x = number;
    add_groups(pass, group, cell.count);
  }
}

// All that move by steps: the shader finds those that splash.
void add_moving(SplashPass& pass, const Scene& scene, const RainPass& rain) {
  for (std::size_t i = 0; i < rain.wind->motion.sizes.size(); ++i) {
    if (pass.splashes.duration_s[i] == 0) continue;
    GpuRainSize gpu = rain.sizes[i];
    gpu.run = {0, 0, 1, 0};
    GpuDropGroup group =
        moving_group(*pass.space, rain.wind->motion, static_cast<int>(i), scene.camera.position_m);
    group.what.x = static_cast<int>(pass.sizes.size());
    pass.sizes.push_back(gpu);
    pass.slab_sizes.push_back(pass.splash_sizes[i]);
    add_groups(pass, group, static_cast<std::uint32_t>(rain.wind->motion.sizes[i].count));
  }
}

void add_single_drops(SplashPass& pass, const Scene& scene, const RainPass& rain, double time_s) {
  for (std::size_t i = 0; i < scene.drops.size(); ++i) {
    const auto index = static_cast<std::size_t>(pass.space->single_sizes[i]);
    GpuDropGroup group = single_group(scene, *pass.space, i, time_s);
    group.what = {static_cast<int>(pass.sizes.size()), static_cast<int>(single_splash_key(i)), 0,
                  0};
    GpuRainSize gpu = rain.sizes[index];
    gpu.run = {0, 0, 1, 0};
    pass.sizes.push_back(gpu);
    pass.slab_sizes.push_back(pass.splash_sizes[index]);
    add_groups(pass, group, 1);
  }
}

template <class T>
void upload(const char* what, GlBuffer& buffer, std::size_t& capacity,
            const std::vector<T>& values) {
  if (values.size() > capacity) {
    capacity = values.size() + values.size() / 4;
    buffer =
        make_storage(fmt::format("splashes: {} {}", values.size(), what), capacity * sizeof(T));
  }
  update_buffer(buffer, values);
}

// Groups, sizes and uniforms of the frame.
void set_frame(SplashPass& pass, const Scene& scene, const RainPass& rain, double time_s) {
  pass.sizes.clear();
  pass.slab_sizes.clear();
  pass.groups.clear();
  if (rain.wind) {
    add_moving(pass, scene, rain);
  } else {
    for (const SplashSlab& slab : splash_slabs(scene, *pass.space, pass.splashes, time_s))
      add_slab(pass, scene, rain, slab);
  }
  add_single_drops(pass, scene, rain, time_s);
  pass.rain = rain.uniforms;
  pass.values.box_min_m = pass.rain.box_min_m;
  pass.values.box_max_m = pass.rain.box_max_m;
  const float late_s = pass.rain.box_min_m.w;
  pass.rain.box_min_m = {-1e30f, -1e30f, -1e30f, late_s};
  pass.rain.box_max_m = glm::vec4(1e30f);
  pass.rain.counts.x = 1 << 16;  // a drop's "oscillation set": 16 bits of its own
  pass.rain.sizes.x = static_cast<int>(pass.groups.size());
  upload("sizes", pass.size_buffer, pass.size_capacity, pass.sizes);
  upload("slabs", pass.splash_size_buffer, pass.slab_capacity, pass.slab_sizes);
  upload("groups of drops", pass.group_buffer, pass.group_capacity, pass.groups);
  glNamedBufferSubData(pass.rain_uniforms.id(), 0, sizeof(pass.rain), &pass.rain);
  glNamedBufferSubData(pass.uniforms.id(), 0, sizeof(pass.values), &pass.values);
}

void bind_inputs(const SplashPass& pass, const RainPass& rain, const ShadowPass& shadows) {
  glBindBufferBase(GL_UNIFORM_BUFFER, rain_uniforms_at, pass.rain_uniforms.id());
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniforms.id());
  bind_storage(sizes_at, pass.size_buffer);
  bind_storage(splash_sizes_at, pass.splash_size_buffer);
  bind_storage(parts_at, pass.parts);
  bind_storage(groups_at, pass.group_buffer);
  bind_storage(group_starts_at, pass.group_starts);
  bind_storage(hits_at, pass.hits);
  bind_storage(strokes_at, pass.strokes);
  bind_storage(lights_at, rain.lights);
  bind_storage(top_heights_at, rain.top_heights);
  if (rain.densities.id()) bind_storage(densities_at, rain.densities);
  if (rain.wind) bind_storage(moving_drops_at, rain.wind->drops);
  bind_storage(phase_at, pass.phase);
  if (shadows.empty()) return;
  bind_storage(shadow_views_at, shadows.view_buffer);
  glBindTextureUnit(shadow_maps_at, shadows.maps.id());
}

void reserve_strokes(SplashPass& pass, std::size_t strokes) {
  if (strokes <= pass.capacity) return;
  const std::size_t capacity = strokes + strokes / 4;
  pass.strokes = make_storage(fmt::format("splashes: {} strokes in view", strokes),
                              capacity * sizeof(StrokeRecord));
  pass.capacity = capacity;
}

}  // namespace

SplashPass make_splash_pass(const Scene& scene, const RainSpace& space, const RainPass& rain,
                            const ShadowPass& shadows) {
  SplashPass pass;
  pass.space = &space;
  pass.splashes = make_splash_space(scene, space);
  pass.splash_sizes = gpu_splash_sizes(pass.splashes);
  pass.values.air = to_glm({scene.camera.exposure_s, gravity_m_s2, 0}, 0);
  pass.parts = make_buffer(gpu_splash_parts(pass.splashes));
  std::vector<float> phase;
  for (const double value : droplet_phase(phase_bins)) phase.push_back(static_cast<float>(value));
  pass.phase = make_buffer(phase);
  pass.rain_uniforms = make_buffer(&pass.rain, sizeof(pass.rain));
  pass.uniforms = make_buffer(&pass.values, sizeof(pass.values));
  pass.no_vertices = make_vertex_array();
  pass.count = build_program({"splash_place.comp"}, defines(false, rain, shadows));
  pass.place = build_program({"splash_place.comp"}, defines(true, rain, shadows));
  pass.draw = build_program({"splash.vert", "splash.frag"}, defines(false, rain, shadows));
  return pass;
}

void place_splashes(SplashPass& pass, const Scene& scene, const RainPass& rain,
                    const ShadowPass& shadows, double time_s) {
  const std::size_t groups_before = pass.group_capacity;
  set_frame(pass, scene, rain, time_s);
  pass.strokes_in_view = 0;
  if (pass.groups.empty()) return;
  if (pass.group_capacity != groups_before) {
    pass.group_starts = make_buffer(nullptr, (pass.group_capacity + 1) * sizeof(GLuint));
    pass.hits = make_storage("splashes: groups of drops",
                             pass.group_capacity * group_size * sizeof(GLuint));
  }
  bind_inputs(pass, rain, shadows);
  dispatch_groups(pass.count, pass.groups.size());
  pass.strokes_in_view =
      write_starts(pass.group_starts, read_counts(pass.group_starts, pass.groups.size()));
  if (pass.strokes_in_view == 0) return;
  reserve_strokes(pass, pass.strokes_in_view);
  bind_inputs(pass, rain, shadows);
  dispatch_groups(pass.place, pass.groups.size());
}

std::string draw_splashes(const SplashPass& pass, const RainPass& rain) {
  if (pass.strokes_in_view == 0) return "no splash in view";
  bind_storage(strokes_at, pass.strokes);
  const float width = rain.uniforms.camera.up.w, height = rain.uniforms.camera.forward.w;
  begin_blending(rain.target, static_cast<int>(width), static_cast<int>(height));
  glBlendFunc(GL_ONE, GL_ONE);
  glUseProgram(pass.draw.id());
  glUniform2f(0, width, height);
  glBindVertexArray(pass.no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * pass.strokes_in_view));
  return "";
}

PlannedPass plan_of(const SplashPass& pass) {
  PlannedPass plan = {.name = "splashes"};
  for (const ShaderProgram* program : {&pass.count, &pass.place, &pass.draw}) plan.add(*program);
  plan.add("uniforms", pass.uniforms);
  plan.add("uniforms of the rain", pass.rain_uniforms);
  plan.add("sizes", pass.size_buffer);
  plan.add("sizes of splashes", pass.splash_size_buffer);
  plan.add("tables", pass.parts);
  plan.add("groups of drops", pass.group_buffer);
  plan.add("starts of groups", pass.group_starts);
  plan.add("drops that splash", pass.hits);
  plan.add("strokes", pass.strokes);
  plan.add("light of a droplet", pass.phase);
  return plan;
}

std::vector<StrokeRecord> read_strokes(const SplashPass& pass) {
  std::vector<StrokeRecord> strokes(pass.strokes_in_view);
  if (!strokes.empty())
    glGetNamedBufferSubData(pass.strokes.id(), 0,
                            static_cast<GLsizeiptr>(strokes.size() * sizeof(StrokeRecord)),
                            strokes.data());
  return strokes;
}

}  // namespace pluvia
