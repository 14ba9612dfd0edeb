#include "realtime/rain_bindings.h"

#include <string>
#include <utility>

#include "raytrace/depth_of_field.h"
#include "realtime/group_passes.h"
#include "realtime/light_candidates.h"
#include "realtime/rain_inputs.h"

namespace pluvia {
namespace {

enum Binding : GLuint {
  uniforms_at,
  group_starts_at,
  streaks_at,
  lit_streaks_at,
  lights_at,
  atlas_lights_at,
  atlas_layers_at,
  atlas_views_at,
  atlas_spans_at,
  centres_at,
  sizes_at,
  groups_at,
  top_heights_at,
  densities_at,
  light_rows_at,
  light_entries_at,
  light_candidates_at,
  sky_at,
  sky_spans_at,
  sky_streaks_at,
  shadow_views_at,
  profile_spans_at,
  splat_sums_at,
  splat_overflow_at,
  transfer_rings_at,
  moving_drops_at,
  mask_outlines_at,
  mask_sizes_at,
  mask_sets_at,
  mask_views_at,
  mask_reaches_at
};

enum TextureUnit : GLuint {
  shadow_maps_at,
  sums_at,
  sky_sums_at,
  profiles_at,
  scene_depth_at,
  point_pictures_at,
  environment_pictures_at,
  coverage_pictures_at,
  masks_at,
  surroundings_at
};

void bind_refraction(const RefractionLook& look) {
  bind_storage(mask_outlines_at, look.outlines);
  bind_storage(mask_sizes_at, look.sizes);
  bind_storage(mask_sets_at, look.sets);
  bind_storage(mask_views_at, look.views);
  bind_storage(mask_reaches_at, look.reaches);
  glBindTextureUnit(masks_at, look.masks.id());
  glBindTextureUnit(surroundings_at, look.capture.picture.id());
}

// What only streaks of one look or another are lit by.
void bind_light(const RainPass& pass) {
  if (pass.look.transfer.id()) bind_storage(transfer_rings_at, pass.look.transfer);
  if (pass.look.sky.id()) bind_storage(sky_at, pass.look.sky);
  if (pass.refraction) bind_refraction(*pass.refraction);
  if (!pass.look.traced()) return;
  bind_storage(atlas_layers_at, pass.atlas_layers);
  if (pass.taps > 1) {
    bind_storage(light_rows_at, pass.light_rows);
    bind_storage(light_entries_at, pass.light_entries);
  } else {
    bind_storage(atlas_lights_at, pass.atlas_lights);
    bind_storage(light_candidates_at, pass.light_candidates);
  }
  if (pass.sky.id()) {
    bind_storage(sky_at, pass.sky);
    bind_storage(sky_spans_at, pass.atlas->sky_spans);
    bind_storage(sky_streaks_at, pass.sky_streaks);
    glBindTextureUnit(sky_sums_at, pass.atlas->sky_sums.id());
  }
}

}  // namespace

ShaderDefines drop_defines(const RainPass& pass) {
  return {{"DENSITY", pass.densities.id() ? "1" : "0"},
          {"MOTION", pass.wind ? "1" : "0"},
          {"DROPS", pass.wind ? "drops_moving.glsl" : "drops_closed.glsl"},
          {"LEAST_SPEED_M_S", std::to_string(least_speed_m_s)},
          {"LENS", pass.lens ? "1" : "0"},
          {"LEAST_CIRCLE_PX", std::to_string(least_circle_px)},
          {"WALKED_CIRCLE_PX", std::to_string(widest_walked_circle_px)}};
}

ShaderDefines rain_defines(const RainPass& pass, bool shadows) {
  ShaderDefines all = {{"SHADOWS", shadows ? "1" : "0"},
                       {"TAPS", std::to_string(pass.taps)},
                       {"VIEW_TAPS", std::to_string(pass.view_taps)},
                       {"SKY_CELLS", std::to_string(pass.sky_cells)},
                       {"SKY_DEGREE", std::to_string(degree_of_cells(pass.sky_cells))},
                       {"GROUP_SIZE", std::to_string(group_size)},
                       {"DROPS_OF_GROUP", std::to_string(drops_of_group)},
                       {"GROUPS_PER_ROW", std::to_string(groups_per_row)},
                       {"QUADS_PER_INSTANCE", std::to_string(quads_per_instance)},
                       {"SUMS_WIDTH", std::to_string(sums_width)},
                       {"SUMS_HEIGHT", std::to_string(sums_height)},
                       {"NEAR_M", std::to_string(near_m)},
                       {"CANDIDATE_CELLS", std::to_string(candidate_cells)},
                       {"BILLBOARD_LIGHTS", std::to_string(most_billboard_lights)},
                       {"SPLAT_LIGHTS", std::to_string(splat_lights)},
                       {"SPLAT_STEPS", std::to_string(splat_steps)}};
  all.merge(drop_defines(pass));
  all.merge(look_defines(pass.look));
  if (pass.refraction) all.merge(ShaderDefines(pass.refraction->defines));
  const std::pair<const char*, GLuint> bindings[] = {
      {"RAIN_UNIFORMS", uniforms_at},
      {"GROUP_STARTS", group_starts_at},
      {"STREAKS", streaks_at},
      {"LIT_STREAKS", lit_streaks_at},
      {"LIGHTS", lights_at},
      {"ATLAS_LIGHTS", atlas_lights_at},
      {"ATLAS_LAYERS", atlas_layers_at},
      {"ATLAS_VIEWS", atlas_views_at},
      {"ATLAS_SPANS", atlas_spans_at},
      {"CENTRES", centres_at},
      {"RAIN_SIZES", sizes_at},
      {"DROP_GROUPS", groups_at},
      {"TOP_HEIGHTS", top_heights_at},
      {"DENSITIES", densities_at},
      {"LIGHT_ROWS", light_rows_at},
      {"LIGHT_ENTRIES", light_entries_at},
      {"LIGHT_CANDIDATES", light_candidates_at},
      {"SKY", sky_at},
      {"SKY_SPANS", sky_spans_at},
      {"SKY_STREAKS", sky_streaks_at},
      {"SKY_SUMS", sky_sums_at},
      {"SHADOW_VIEWS", shadow_views_at},
      {"SHADOW_MAPS", shadow_maps_at},
      {"CUMULATIVE", sums_at},
      {"PROFILES", profiles_at},
      {"SCENE_DEPTH", scene_depth_at},
      {"PROFILE_SPANS", profile_spans_at},
      {"SPLAT_SUMS", splat_sums_at},
      {"SPLAT_OVERFLOW", splat_overflow_at},
      {"TRANSFER", transfer_rings_at},
      {"MASK_OUTLINES", mask_outlines_at},
      {"MASK_SIZES", mask_sizes_at},
      {"MASK_SETS", mask_sets_at},
      {"MASK_VIEWS", mask_views_at},
      {"MASK_REACHES", mask_reaches_at},
      {"MASKS", masks_at},
      {"SURROUNDINGS", surroundings_at},
      {"POINT_PICTURES", point_pictures_at},
      {"ENVIRONMENT_PICTURES", environment_pictures_at},
      {"COVERAGE_PICTURES", coverage_pictures_at},
      {"MOVING_DROPS", moving_drops_at}};
  for (const auto& [name, number] : bindings) all[name] = std::to_string(number);
  return all;
}

void bind_rain(const RainPass& pass) {
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniform_buffer.id());
  bind_storage(group_starts_at, pass.group_starts);
  bind_storage(streaks_at, pass.streaks);
  bind_storage(lit_streaks_at, pass.lit_streaks);
  bind_storage(lights_at, pass.lights);
  bind_storage(atlas_views_at, pass.atlas_views);
  bind_storage(atlas_spans_at, pass.atlas->spans);
  if (!pass.splat.empty()) {
    bind_storage(profile_spans_at, pass.splat.atlas->spans);
    bind_storage(splat_sums_at, pass.splat.sums);
    bind_storage(splat_overflow_at, pass.splat.overflow);
    glBindTextureUnit(profiles_at, pass.splat.atlas->profiles.id());
  }
  bind_storage(sizes_at, pass.size_buffer);
  bind_storage(groups_at, pass.group_buffer);
  bind_storage(top_heights_at, pass.top_heights);
  if (pass.densities.id()) bind_storage(densities_at, pass.densities);
  if (pass.wind) bind_storage(moving_drops_at, pass.wind->drops);
  bind_light(pass);
  glBindTextureUnit(sums_at, pass.atlas->sums.id());
}

void bind_shadows(const ShadowPass& shadows) {
  bind_storage(shadow_views_at, shadows.view_buffer);
  glBindTextureUnit(shadow_maps_at, shadows.maps.id());
}

void bind_scene_depth(const RainPass& pass) {
  glBindTextureUnit(scene_depth_at, pass.scene_depth_m);
}

void bind_billboards(const BillboardPass& billboards) {
  glBindTextureUnit(point_pictures_at, billboards.point.id());
  glBindTextureUnit(environment_pictures_at, billboards.environment.id());
  glBindTextureUnit(coverage_pictures_at, billboards.coverage.id());
}

void bind_centres(const GlBuffer& centres) {
  bind_storage(centres_at, centres);
}

}  // namespace pluvia
