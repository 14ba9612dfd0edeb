#include "realtime/rain_look.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/vec4.hpp>

#include "atlas/stroke_coverage.h"
#include "raytrace/sphere_transfer.h"
#include "realtime/rain_inputs.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

// Whose thin streaks have the lights of spheres.
bool has_transfer(StreakLook look) {
  return look != StreakLook::traced && look != StreakLook::white;
}

bool is_sphere(StreakLook look) {
  return look == StreakLook::sphere || look == StreakLook::sphere_published;
}

SphereTransferOptions transfer_options(StreakLook look) {
  const bool published = look == StreakLook::sphere_published;
  return {.averaged_reflectance = published, .single_root = published};
}

// c_lm k_l, in the world.
std::vector<glm::vec4> seen_through_sphere(const SphereTransferOptions& options,
                                           const SkyLight& sky) {
  const int degree = degree_of(sky);
  const std::vector<double> harmonics = transfer_harmonics(options, degree);
  std::vector<glm::vec4> values;
  for (int l = 0; l <= degree; ++l) {
    for (Eigen::Index i = l * l; i < (l + 1) * (l + 1); ++i)
      values.push_back(
          to_glm(harmonics[static_cast<std::size_t>(l)] * sky.coefficients.row(i).transpose(), 0));
  }
  return values;
}

// On screen a streak covers more than its texels do where its path is shorter, in radii, than that
// of the pictures; the shortest counts. Where paths are longer, the ends of a streak are not.
double most_texel_coverage(const StreakAtlas& atlas, const RainSpace& space, double exposure_s) {
  const double picture = atlas.fall_speed_m_s * atlas.exposure_s / atlas.mean_radius_m;
  double most = 1;
  for (const RainSizeSpace& size : space.sizes)
    most = std::min(most, size.speed_m_s * exposure_s / size.drops.r0_m / picture);
  return most;
}

std::string strokes_note(const StreakStrokes& strokes) {
  if (strokes.found == strokes.taken.size())
    return fmt::format("they have the shapes of {} strokes", strokes.taken.size());
  return fmt::format("they have the shapes of the {} longest of {} strokes", strokes.taken.size(),
                     strokes.found);
}

}  // namespace

void check_look(const RenderOptions& options) {
  if (options.look != StreakLook::traced && options.path == RainPath::billboards_2010)
    throw std::runtime_error("billboards: a look that is not traced; expected traced");
  if (options.background_share && !is_sphere(options.look))
    throw std::runtime_error("background_share: the look has none; expected a look of spheres");
  if (options.streak_cd_m2 && options.look != StreakLook::white)
    throw std::runtime_error("streak_cd_m2: the look has none; expected white");
  // 1 would hide nothing, and leave the composite no coverage to go by.
  if (options.background_share &&
      !(*options.background_share >= 0 && *options.background_share <= 0.99))
    throw std::runtime_error(
        fmt::format("background_share = {}; expected 0 .. 0.99", *options.background_share));
  if (options.streak_cd_m2 && !(*options.streak_cd_m2 >= 0 && *options.streak_cd_m2 <= 1e9))
    throw std::runtime_error(
        fmt::format("streak_cd_m2 = {}; expected 0 .. 1e9", *options.streak_cd_m2));
}

RainLook make_rain_look(const Scene& scene, const RenderOptions& options, const SkyLight& sky) {
  check_look(options);
  RainLook look = {.look = options.look};
  if (look.look == StreakLook::white)
    look.streak_cd_m2 = options.streak_cd_m2.value_or(scene.camera.white_cd_m2);
  if (!has_transfer(look.look)) return look;
  const bool published = look.look == StreakLook::sphere_published;
  look.background_share =
      options.background_share.value_or(published ? published_background_share : 0);
  if (!scene.lights.empty()) {
    const std::vector<double> rings = sphere_transfer(transfer_options(look.look), transfer_rings);
    look.brightest_per_lux = *std::max_element(rings.begin(), rings.end());
    look.transfer = make_buffer(std::vector<float>(rings.begin(), rings.end()));
  }
  if (is_sphere(look.look)) look.sky_cells = sky_cells(sky);
  if (look.sky_cells > 0)
    look.sky = make_buffer(seen_through_sphere(transfer_options(look.look), sky));
  return look;
}

void set_sky(const RainLook& look, const SkyLight& sky) {
  if (look.sky.id()) update_buffer(look.sky, seen_through_sphere(transfer_options(look.look), sky));
}

bool takes_strokes(StreakLook look) {
  return is_sphere(look) || look == StreakLook::white;
}

StreakAtlas coverage_alone(const StreakAtlas& atlas, const RainSpace& space, double exposure_s) {
  if (!atlas.strokes.empty())
    return stroke_coverage(atlas, most_texel_coverage(atlas, space, exposure_s));
  StreakAtlas dark = places_of(atlas);
  for (const AtlasLayer& layer : atlas.layers)
    dark.layers.push_back({.oscillation = layer.oscillation, .coverage = layer.coverage});
  return dark;
}

std::vector<std::string> look_notes(const RainLook& look, const StreakStrokes& strokes) {
  if (look.look == StreakLook::refraction) return {};  // refraction_look.h has them
  std::string note = look.look == StreakLook::sphere
                         ? "streaks shine as spheres do"
                         : "streaks shine as spheres do, as published in 2006";
  if (look.look == StreakLook::white)
    note = fmt::format("streaks are white: {:.4g} cd/m2 whatever the light", look.streak_cd_m2);
  if (look.sky_cells > 0) note += fmt::format("; the sky in {} harmonics", look.sky_cells);
  if (look.background_share > 0)
    note += fmt::format("; with {} of the background behind them", look.background_share);
  if (!strokes.empty()) note += "; " + strokes_note(strokes);
  return {note};
}

ShaderDefines look_defines(const RainLook& look) {
  if (look.traced())
    return {{"TRACED", "1"}, {"REFRACTION", "0"}, {"STREAK_LIGHT", "rain_light.glsl"}};
  const bool refracts = look.look == StreakLook::refraction;
  return {{"TRACED", "0"},
          {"STREAK_LIGHT", refracts ? "rain_refraction_light.glsl" : "rain_look.glsl"},
          {"REFRACTION", refracts ? "1" : "0"},
          {"SPHERE", is_sphere(look.look) ? "1" : "0"},
          {"LOOK_LIGHTS", look.transfer.id() ? "1" : "0"},
          {"TRANSFER_RINGS", std::to_string(transfer_rings)},
          {"LOOK_HARMONICS", std::to_string(look.sky_cells)},
          {"STREAK_CD_M2", fmt::format("{:.9e}", look.streak_cd_m2)},
          {"HIDDEN_SHARE", fmt::format("{:.9e}", 1 - look.background_share)}};
}

}  // namespace pluvia
