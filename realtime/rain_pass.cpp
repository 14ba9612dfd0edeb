#include "realtime/rain_pass.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "atlas/stroke_coverage.h"
#include "raytrace/depth_of_field.h"
#include "realtime/group_passes.h"
#include "realtime/light_candidates.h"
#include "realtime/rain_bindings.h"
#include "realtime/rain_inputs.h"
#include "realtime/shader.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

GlBuffer upload_values(const std::string& what, const std::vector<float>& values) {
  GlBuffer buffer = make_storage(what, values.size() * sizeof(float));
  update_buffer(buffer, values);
  return buffer;
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

void upload_uniforms(const RainPass& pass) {
  glNamedBufferSubData(pass.uniform_buffer.id(), 0, sizeof(pass.uniforms), &pass.uniforms);
}

long drops_in(const std::vector<GpuDropGroup>& groups, const std::vector<GpuRainSize>& sizes) {
  std::vector<long> items(sizes.size(), 0);  // a drop has one for each segment
  for (const GpuDropGroup& group : groups)
    items[static_cast<std::size_t>(group.what.x)] += group.drops.w;
  long drops = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) drops += items[i] / sizes[i].run.z;
  return drops;
}

DropLayers drop_layers(const RainPass& pass) {
  const int each = std::max(1, pass.shapes_of_set);
  return {pass.uniforms.counts.x / each, each};
}

void choose_cells(RainPass& pass, const Scene& scene, double time_s) {
  const PacketChoice choice =
      select_packets(scene.rain, *pass.space, pass.packets, scene.camera, time_s);
  const std::vector<SizedCell> cells =
      packet_cells(scene.rain, *pass.space, choice, scene.camera, time_s);
  pass.groups = drop_groups(scene, *pass.space, cells, pass.sizes, drop_layers(pass), time_s,
                            drops_of_group, pass.far_streaks);
  pass.counts = {.packets_looked_at = choice.looked_at,
                 .packets_taken = static_cast<long>(choice.packets.size())};
  pass.counts.drops_looked_at = drops_in(pass.groups, pass.sizes);
  for (const SizedCell& cell : cells) pass.counts.drops_stood_for += cell.cell.count;
  pass.counts.drops_stood_for +=
      static_cast<long>(scene.drops.size()) - pass.counts.drops_looked_at;
}

void choose_moving(RainPass& pass, const Scene& scene, double time_s) {
  pass.groups = moving_groups(scene, *pass.space, pass.wind->motion, pass.sizes, drop_layers(pass),
                              time_s, drops_of_group);
  pass.counts = {.drops_looked_at = drops_in(pass.groups, pass.sizes)};
  pass.uniforms.box_min_m.w = static_cast<float>(late_s(*pass.wind, time_s));
}

// The groups of drops that this frame looks at.
void upload_groups(RainPass& pass, const Scene& scene, const ShadowPass& shadows, double time_s) {
  set_frame(scene, *pass.space, time_s, pass.uniforms, pass.sizes);
  pass.uniforms.camera_m = to_glm(scene.camera.position_m - pass.origin_m, 0);
  pass.wind ? choose_moving(pass, scene, time_s) : choose_cells(pass, scene, time_s);
  if (pass.groups.size() > pass.group_capacity) {
    pass.group_capacity = pass.groups.size() + pass.groups.size() / 4;
    pass.group_buffer = make_storage(fmt::format("rain: {} groups of drops", pass.groups.size()),
                                     pass.group_capacity * sizeof(GpuDropGroup));
    pass.group_starts =
        make_buffer(nullptr, (thread_groups(pass.group_capacity) + 1) * sizeof(GLuint));
  }
  update_buffer(pass.group_buffer, pass.groups);
  update_buffer(pass.size_buffer, pass.sizes);
  update_buffer(pass.lights, gpu_lights(scene, shadows.slots));
  pass.uniforms.sizes.x = static_cast<int>(pass.groups.size());
  upload_uniforms(pass);
}

struct StreakCounts {
  std::size_t wide = 0, thin = 0;
};

// Leaves where the wide streaks of each group begin to the placing shader.
StreakCounts sum_groups(const RainPass& pass) {
  std::vector<GLuint> groups = read_counts(pass.group_starts, thread_groups(pass.groups.size()));
  StreakCounts total;
  for (GLuint& group : groups) {  // thin ones are counted in the upper half (rain_splat.comp)
    total.thin += group >> 16;
    group &= 0xffffu;
  }
  total.wide = write_starts(pass.group_starts, std::move(groups));
  return total;
}

std::size_t lit_per_streak(const RainPass& pass) {  // rain_streaks.glsl
  if (pass.refraction) return static_cast<std::size_t>(pass.uniforms.counts.y) + 1;
  if (!pass.look.traced()) return 1;
  return static_cast<std::size_t>(pass.uniforms.counts.y * pass.taps + (pass.sky_cells == 1));
}

void reserve_records(RainPass& pass, std::size_t streaks) {
  if (streaks <= pass.capacity) return;
  const std::size_t capacity = streaks + streaks / 4;  // the next frames may show a few more
  const std::size_t cells = lit_per_streak(pass);
  const std::string what =
      fmt::format("rain: {} streaks in view, each lit by {} cells,", streaks, cells);
  pass.streaks = make_storage(what, capacity * sizeof(StreakRecord));
  pass.lit_streaks = make_storage(what, capacity * cells * sizeof(LitStreakRecord));
  if (pass.sky_cells > 1)
    pass.sky_streaks = make_buffer(nullptr, capacity * sizeof(SkyOfStreakRecord));
  pass.capacity = capacity;
}

void dispatch(const RainPass& pass, const ShaderProgram& program) {
  bind_rain(pass);
  dispatch_groups(program, thread_groups(pass.groups.size()));
}

void begin_streaks(const RainPass& pass, const GlFramebuffer& target) {
  begin_blending(target, static_cast<int>(pass.uniforms.camera.up.w),
                 static_cast<int>(pass.uniforms.camera.forward.w));
}

// Draws the thin streaks too, where the pass has that.
StreakCounts count_streaks(RainPass& pass) {
  if (pass.splat.empty()) {
    dispatch(pass, pass.count);
    return sum_groups(pass);
  }
  bind_scene_depth(pass);
  dispatch(pass, pass.splat.program);
  if (splat_overflowed(pass.splat)) {
    // Once more with every streak as a quad, whose sums are floats.
    pass.uniforms.splat.x = 0;
    upload_uniforms(pass);
    clear_splat(pass.splat);
    dispatch(pass, pass.splat.program);
  }
  return sum_groups(pass);
}

std::string lens_note(const Camera& camera, bool billboards) {
  if (billboards) return "depth of field: billboards are sharp";
  if (has_circles(camera))
    return "depth of field: surfaces are sharp, splashes out of focus are oblong";
  return fmt::format("depth of field: no circle of more than {:.2g} px, nothing to see",
                     largest_circle_px(camera));
}

// What traced streaks are lit by, beside the atlas's sums.
void make_traced_light(const StreakAtlas& atlas, const RenderOptions& options, const SkyLight& sky,
                       RainPass& pass) {
  if (pass.sky_cells > 1) pass.sky = make_buffer(gpu_sky(sky, *pass.space));
  pass.atlas_layers = make_buffer(mirrored_layers(atlas));
  if (options.lookup == LookupMode::trilinear) {
    pass.taps = 4;
    pass.light_rows = make_buffer(gpu_light_rows(atlas));
    pass.light_entries = make_buffer(gpu_light_entries(atlas));
  } else {
    pass.atlas_lights = make_buffer(atlas_light_directions(atlas));
    pass.light_candidates = make_buffer(light_candidates(light_vectors(atlas)));
  }
}

void make_billboards(const Scene& scene, const StreakAtlas& atlas, const ShadowPass& shadows,
                     RainPass& pass) {
  if (pass.taps > 1)
    throw std::runtime_error("billboards: lookup trilinear; expected nearest or view-linear");
  pass.billboards = make_billboard_pass(scene, atlas, pass.sky_cells > 0);
  pass.billboards.program = build_program({"billboard.vert", "billboard.geom", "billboard.frag"},
                                          rain_defines(pass, !shadows.empty()));
}

void build_programs(const ShadowPass& shadows, RainPass& pass) {
  const ShaderDefines plain = rain_defines(pass, false);
  const ShaderDefines shaded = rain_defines(pass, !shadows.empty());
  if (pass.splat.empty())
    pass.count = build_program({"rain_count.comp"}, plain);
  else
    pass.splat.program = build_program({"rain_splat.comp"}, shaded);
  pass.place = build_program({"rain_place.comp"}, shaded);
  pass.draw =
      build_program({"rain.vert", pass.refraction ? "rain_refraction.frag" : "rain.frag"}, plain);
}

}  // namespace

RainPass make_rain_pass(const Scene& scene, const RainSpace& space, const StreakAtlas& whole_atlas,
                        const RenderOptions& options, const SkyLight& sky,
                        const ScenePass& surfaces, const ShadowPass& shadows, const WindPass* wind,
                        const GpuAtlas& kept_atlas) {
  check_rain_inputs(scene, whole_atlas, options);
  RainPass pass;
  pass.look = make_rain_look(scene, options, sky);
  const StreakAtlas dark = pass.look.traced()
                               ? StreakAtlas()
                               : coverage_alone(whole_atlas, space, scene.camera.exposure_s);
  const StreakAtlas& atlas = pass.look.traced() ? whole_atlas : dark;
  // Strokes have a coverage of their own, which the exposure bounds.
  const GpuAtlas kept = atlas.strokes.empty() ? kept_atlas : GpuAtlas();
  if (!atlas.strokes.empty()) pass.shapes_of_set = shapes_of_set(whole_atlas);
  pass.origin_m = scene.camera.position_m;
  pass.space = &space;
  pass.wind = wind;
  pass.packets = make_rain_packets(scene.rain, *pass.space, options.packets);
  pass.uniforms = rain_uniforms(scene, atlas, options);
  pass.sizes = gpu_rain_sizes(scene, *pass.space, atlas);
  if (options.look == StreakLook::refraction)
    pass.refraction = make_refraction_look(scene, whole_atlas, options, pass.sizes);
  pass.uniforms.environment = to_glm(mean_radiance(sky), 0);
  // A streak lets so much through that others hide less of those behind them, too.
  pass.uniforms.air.y *= static_cast<float>(1 - pass.look.background_share);
  pass.sky_cells = pass.look.traced() ? sky_cells(sky) : 0;
  pass.notes = pass.look.traced() ? sky_notes(scene, atlas, options, sky)
                                  : look_notes(pass.look, atlas.strokes);
  pass.atlas =
      upload_sums(atlas, {.finest = pass.uniforms.sizes.y, .coarsest = pass.uniforms.sizes.z},
                  pass.sky_cells, kept.sums);
  if (!scene.rain.density.share.empty())
    pass.densities = upload_values("rain: the texels of the density map", scene.rain.density.share);
  pass.top_heights = upload_values("rain: top heights", gpu_top_heights(space));
  pass.uniform_buffer = make_buffer(&pass.uniforms, sizeof(pass.uniforms));
  pass.size_buffer = make_buffer(pass.sizes);
  pass.lights = make_buffer(gpu_lights(scene, shadows.slots));
  pass.atlas_views = make_buffer(atlas_views(atlas));
  pass.view_taps = options.lookup == LookupMode::nearest ? 1 : 2;
  if (pass.look.traced()) make_traced_light(atlas, options, sky, pass);
  pass.quads = make_quads(pass.quad_indices);
  pass.sum = make_texture(GL_RGBA32F, surfaces.width, surfaces.height);
  pass.coverage = make_texture(GL_R32F, surfaces.width, surfaces.height);
  pass.seen = make_texture(GL_RGBA32F, surfaces.width, surfaces.height);
  pass.target = make_framebuffer({pass.sum.id(), pass.coverage.id()}, surfaces.depth.id());
  const bool billboards = options.path == RainPath::billboards_2010;
  pass.lens = !billboards && has_circles(scene.camera);
  pass.far_streaks = billboards ? 0 : options.far_streaks;
  if (wind && options.far_streaks > 0)
    pass.notes.push_back("drops that move by steps are all drawn: far_streaks does nothing");
  if (scene.camera.depth_of_field) pass.notes.push_back(lens_note(scene.camera, billboards));
  if (billboards) {
    make_billboards(scene, atlas, shadows, pass);
    return pass;
  }
  SplatUniforms splat;
  pass.splat =
      make_rain_splat(scene, atlas, options, pass.look, pass.sky_cells, kept.profiles, splat);
  pass.uniforms.splat = splat.splat, pass.uniforms.splat_most = splat.most;
  pass.uniforms.splat_levels = splat.levels;
  pass.scene_depth_m = surfaces.depth_m.id();
  if (pass.splat.empty() && options.widest_splat_px > 0)
    pass.notes.push_back(why_all_quads(scene.camera, most_storage_bytes()));
  build_programs(shadows, pass);
  return pass;
}

void set_sky(RainPass& pass, const SkyLight& sky) {
  pass.uniforms.environment = to_glm(mean_radiance(sky), 0);
  if (pass.sky.id()) update_buffer(pass.sky, gpu_sky(sky, *pass.space));
  set_sky(pass.look, sky);
}

GpuAtlas atlas_of(const RainPass& pass) {
  if (pass.shapes_of_set > 0) return {};
  return {pass.atlas, pass.splat.atlas};
}

long place_rain(RainPass& pass, const Scene& scene, const ShadowPass& shadows, double time_s) {
  pass.uniforms.sizes.w = 0;
  pass.uniforms.splat.x = static_cast<float>(pass.splat.widest_px);
  upload_groups(pass, scene, shadows, time_s);
  if (!pass.splat.empty()) clear_splat(pass.splat);
  if (pass.groups.empty()) return 0;
  if (!shadows.empty()) bind_shadows(shadows);
  if (!pass.billboards.empty()) return pass.counts.drops_looked_at;
  const StreakCounts streaks = count_streaks(pass);
  reserve_records(pass, streaks.wide);
  pass.uniforms.sizes.w = static_cast<int>(streaks.wide);
  upload_uniforms(pass);
  if (streaks.wide > 0) dispatch(pass, pass.place);
  return static_cast<long>(streaks.wide + streaks.thin);
}

void draw_billboards(const RainPass& pass, const GlFramebuffer& picture) {
  if (pass.groups.empty()) return;
  bind_rain(pass);
  bind_billboards(pass.billboards);
  begin_streaks(pass, picture);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glUseProgram(pass.billboards.program.id());
  glBindVertexArray(pass.billboards.no_vertices.id());
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(pass.groups.size() * drops_of_group));
}

void draw_rain(const RainPass& pass) {
  const float dry[4] = {0, 0, 0, 0};
  for (const GLint target : {0, 1})
    glClearNamedFramebufferfv(pass.target.id(), GL_COLOR, target, dry);
  if (pass.uniforms.sizes.w == 0) return;
  bind_rain(pass);
  begin_streaks(pass, pass.target);
  glBlendFunc(GL_ONE, GL_ONE);
  glUseProgram(pass.draw.id());
  glBindVertexArray(pass.quads.id());
  const int instances = (pass.uniforms.sizes.w + quads_per_instance - 1) / quads_per_instance;
  glDrawElementsInstanced(GL_TRIANGLES, 6 * quads_per_instance, GL_UNSIGNED_INT, nullptr,
                          instances);
}

PlannedPass plan_of(const RainPass& pass) {
  PlannedPass plan = {.name = "rain", .notes = pass.notes};
  for (const ShaderProgram* program : {&pass.count, &pass.place, &pass.draw}) plan.add(*program);
  plan_splat(pass.splat, plan);
  plan_billboards(pass.billboards, plan);
  plan.add("uniforms", pass.uniform_buffer);
  plan.add("sizes", pass.size_buffer);
  plan.add("groups of drops", pass.group_buffer);
  plan.add("starts of groups", pass.group_starts);
  plan.add("top heights", pass.top_heights);
  plan.add("density map", pass.densities);
  plan.add("streaks", pass.streaks);
  plan.add("lit streaks", pass.lit_streaks);
  plan.add("lights", pass.lights);
  plan.add("atlas: lights", pass.atlas_lights);
  plan.add("atlas: rows of lights", pass.light_rows);
  plan.add("atlas: lights of rows", pass.light_entries);
  plan.add("atlas: lights by direction", pass.light_candidates);
  plan.add("transfer function", pass.look.transfer);
  plan.add("sky as spheres see it", pass.look.sky);
  if (pass.refraction) plan_refraction(*pass.refraction, plan);
  plan.add("sky", pass.sky);
  plan.add("sky of streaks", pass.sky_streaks);
  plan.add("atlas: spans of the sky", pass.atlas->sky_spans);
  plan.add("atlas: sums of the sky", pass.atlas->sky_sums);
  plan.add("atlas: layers", pass.atlas_layers);
  plan.add("atlas: views", pass.atlas_views);
  plan.add("atlas: spans", pass.atlas->spans);
  plan.add("atlas: sums", pass.atlas->sums);
  plan.add("quads", pass.quad_indices);
  plan.add("sum of streaks", pass.sum);
  plan.add("sum of coverage", pass.coverage);
  plan.add("rain of the picture", pass.seen);
  return plan;
}

StreakRecords read_records(const RainPass& pass) {
  StreakRecords records;
  const auto streaks = static_cast<std::size_t>(pass.uniforms.sizes.w);
  records.streaks.resize(streaks);
  records.lit_per_streak = lit_per_streak(pass);
  records.lit.resize(streaks * records.lit_per_streak);
  if (streaks == 0) return records;
  if (pass.sky_cells > 1) {
    records.sky.resize(streaks);
    glGetNamedBufferSubData(pass.sky_streaks.id(), 0,
                            static_cast<GLsizeiptr>(streaks * sizeof(SkyOfStreakRecord)),
                            records.sky.data());
  }
  glGetNamedBufferSubData(pass.streaks.id(), 0,
                          static_cast<GLsizeiptr>(streaks * sizeof(StreakRecord)),
                          records.streaks.data());
  if (!records.lit.empty())
    glGetNamedBufferSubData(pass.lit_streaks.id(), 0,
                            static_cast<GLsizeiptr>(records.lit.size() * sizeof(LitStreakRecord)),
                            records.lit.data());
  return records;
}

std::vector<float> read_centres_m(RainPass& pass, const Scene& scene, const ShadowPass& shadows,
                                  double time_s) {
  if (pass.centres.id() == 0)
    pass.centres = build_program({"rain_centres.comp"}, rain_defines(pass, false));
  upload_groups(pass, scene, shadows, time_s);
  if (pass.groups.empty()) return {};
  std::vector<float> values(4 * pass.groups.size() * drops_of_group);
  const GlBuffer buffer = make_buffer(values);
  bind_centres(buffer);
  dispatch(pass, pass.centres);
  glGetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
                          values.data());
  std::vector<float> centres;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    if (values[i + 3] > 0) centres.insert(centres.end(), &values[i], &values[i + 3]);
  }
  return centres;
}

}  // namespace pluvia
