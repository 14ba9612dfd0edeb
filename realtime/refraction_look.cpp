#include "realtime/refraction_look.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/vec2.hpp>

#include "raytrace/drop_motion.h"

namespace pluvia {
namespace {

void check_options(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options) {
  if (atlas.masks.exits.values.empty())
    throw std::runtime_error("look refraction: no masks; expected those of `pluvia masks`");
  if (options.persistence_samples < 1 || options.persistence_samples > most_persistence_samples)
    throw std::runtime_error(fmt::format("persistence_samples = {}; expected 1 .. {}",
                                         options.persistence_samples, most_persistence_samples));
  if (options.capture_px < 16 || options.capture_px > 4096)
    throw std::runtime_error(
        fmt::format("capture_px = {}; expected 16 .. 4096", options.capture_px));
  if (needs_motion(scene.rain))
    throw std::runtime_error(
        "look refraction: drops that wind moves by steps; expected an even wind");
  if (has_circles(scene.camera))
    throw std::runtime_error("look refraction: a lens out of focus; expected a pinhole");
}

GlTexture upload_masks(const RefractionMasks& masks) {
  GLint most_layers = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  const auto layers = static_cast<int>(mask_count(masks));
  if (layers > most_layers)
    throw std::runtime_error(
        fmt::format("{} masks; expected at most {} on this OpenGL", layers, most_layers));
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  glTextureStorage3D(id, 1, GL_RGBA16F, masks.exits.width, masks.size_px, layers);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(id, 0, 0, 0, 0, masks.exits.width, masks.size_px, layers, GL_RGBA, GL_FLOAT,
                      masks.exits.values.data());
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

std::vector<int> sets_of_layers(const RefractionMasks& masks, const StreakAtlas& atlas) {
  std::vector<int> sets;
  for (const AtlasLayer& layer : atlas.layers) {
    const auto found =
        std::find(masks.oscillations.begin(), masks.oscillations.end(), layer.oscillation);
    if (found == masks.oscillations.end())
      throw std::runtime_error(fmt::format(
          "masks: none of oscillation {}; expected all of the atlas", layer.oscillation));
    sets.push_back(static_cast<int>(found - masks.oscillations.begin()));
  }
  return sets;
}

// Of each size the nearest diameter, and the share of its masks' time that a streak shows, as long
// as oscillations of that radius take. Throws std::runtime_error where they show less.
std::vector<glm::vec2> mask_sizes(const RefractionMasks& masks, std::vector<GpuRainSize>& sizes) {
  std::vector<glm::vec2> values;
  for (GpuRainSize& size : sizes) {
    const double r0_m = static_cast<double>(size.velocity_m_s.w);
    const float longer = std::max(size.times.z, 1.0f);  // the picture than the exposure
    size.times.x /= longer;
    size.times.z /= longer;
    const auto diameter = static_cast<std::size_t>(nearest_diameter(masks, r0_m));
    const double slower = std::pow(2e6 * r0_m / masks.diameters_um[diameter], 1.5);
    const double shown_s = masks.durations_s[diameter] * slower;
    const double share = static_cast<double>(size.times.x) / shown_s;
    if (share > 1 + 1e-5)
      throw std::runtime_error(fmt::format(
          "masks: {:.4g} s of a drop of {:.3g} mm; expected {:.4g} s or more, as the atlas shows",
          shown_s, 2e3 * r0_m, size.times.x));
    values.emplace_back(diameter, share);
  }
  return values;
}

ShaderDefines defines_of(const RefractionMasks& masks, const RenderOptions& options,
                         const CapturePass& capture) {
  const auto number = [](double value) { return fmt::format("{:.9e}", value); };
  return {{"PERSISTENCE", std::to_string(options.persistence_samples)},
          {"CAPTURE_CUBE", capture.kind == SceneCapture::cube ? "1" : "0"},
          {"CAPTURE_PX", std::to_string(capture.size_px)},
          {"CAPTURE_LEVELS", std::to_string(capture_levels(capture))},
          {"CAPTURE_TANGENT", number(wide_tangent)},
          {"LAMP_SINE", number(std::sin(masks.cone_half_angle_rad))},
          {"REFRACTIVE_INDEX", number(masks.refractive_index)},
          {"MASK_PX", std::to_string(masks.size_px)},
          {"MASK_ORDERS", std::to_string(masks.orders)},
          {"MASK_PHASES", std::to_string(masks.phases)},
          {"MASK_INSTANTS", std::to_string(masks.instants)},
          {"MASK_ANGLES", std::to_string(masks.outlines.width)},
          {"MASK_SET_COUNT", std::to_string(masks.oscillations.size())},
          {"MASK_VIEW_COUNT", std::to_string(masks.view_elevations_deg.size())}};
}

}  // namespace

std::vector<float> outline_reaches(const RefractionMasks& masks) {
  const std::size_t of_each =
      static_cast<std::size_t>(masks.instants) * static_cast<std::size_t>(masks.outlines.width);
  std::vector<float> reaches;
  for (std::size_t i = 0; i < masks.outlines.values.size(); i += of_each) {
    const auto first = masks.outlines.values.begin() + static_cast<std::ptrdiff_t>(i);
    reaches.push_back(*std::max_element(first, first + static_cast<std::ptrdiff_t>(of_each)));
  }
  return reaches;
}

int nearest_diameter(const RefractionMasks& masks, double r0_m) {
  const auto distance_um = [&](int um) { return std::abs(um - 2e6 * r0_m); };
  const auto found =
      std::min_element(masks.diameters_um.begin(), masks.diameters_um.end(),
                       [&](int a, int b) { return distance_um(a) < distance_um(b); });
  return static_cast<int>(found - masks.diameters_um.begin());
}

RefractionLook make_refraction_look(const Scene& scene, const StreakAtlas& atlas,
                                    const RenderOptions& options, std::vector<GpuRainSize>& sizes) {
  check_options(scene, atlas, options);
  const RefractionMasks& masks = atlas.masks;
  RefractionLook look;
  look.capture = make_capture_pass(options.capture, options.capture_px);
  look.masks = upload_masks(masks);
  look.outlines = make_buffer(masks.outlines.values);
  look.sizes = make_buffer(mask_sizes(masks, sizes));
  look.sets = make_buffer(sets_of_layers(masks, atlas));
  look.views = make_buffer(
      std::vector<float>(masks.view_elevations_deg.begin(), masks.view_elevations_deg.end()));
  look.reaches = make_buffer(outline_reaches(masks));
  look.defines = defines_of(masks, options, look.capture);
  look.notes = {fmt::format("streaks refract: {} orders, {} samples of the drop in each pixel",
                            masks.orders, options.persistence_samples)};
  return look;
}

void plan_refraction(const RefractionLook& look, PlannedPass& plan) {
  plan.notes.insert(plan.notes.end(), look.notes.begin(), look.notes.end());
  plan.add("refraction masks", look.masks);
  plan.add("outlines of drops", look.outlines);
  plan.add("masks: sizes of drops", look.sizes);
  plan.add("masks: sets of layers", look.sets);
  plan.add("masks: views", look.views);
  plan.add("masks: reaches", look.reaches);
}

}  // namespace pluvia
