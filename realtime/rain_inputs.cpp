#include "realtime/rain_inputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atlas_lookup.h"
#include "raytrace/drop_field.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

// A shader loops over the scene's lights and, for each, over the atlas's: llvmpipe ends a shader
// without a word after 65,535 rounds.
constexpr std::size_t most_lights = 512;

constexpr double nearest_depth_m = 0.1;  // place_streak draws no drop that is nearer

void expect_same(const char* name, double value, double expected, const char* unit) {
  // Both come from decimal text: equal numbers may differ by a few roundings, not by a millionth.
  if (std::abs(value - expected) <= 1e-6 * std::abs(expected)) return;
  throw std::runtime_error(fmt::format("scene: {} = {:.6g} {}; expected {:.6g} {} as in the atlas",
                                       name, value, unit, expected, unit));
}

void expect_one_top(const StreakAtlas& atlas) {
  for (const AtlasView& view : atlas.views) {
    if (std::abs(view.path_top_row - atlas.views[0].path_top_row) > 1e-6)
      throw std::runtime_error(
          fmt::format("atlas: view {} deg has path_top_row = {}; expected {} as in view {} deg",
                      view.elevation_deg, view.path_top_row, atlas.views[0].path_top_row,
                      atlas.views[0].elevation_deg));
  }
}

// Distance along the camera's axis of the nearest corner of the rain's box.
double nearest_box_depth_m(const Scene& scene) {
  const CameraFrame frame = camera_frame(scene.camera);
  double nearest = 1e300;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d p;
    for (int i = 0; i < 3; ++i)
      p[i] = (corner >> i & 1) ? scene.rain.box_max_m[i] : scene.rain.box_min_m[i];
    nearest = std::min(nearest, frame.forward.dot(p - scene.camera.position_m));
  }
  return nearest;
}

}  // namespace

void check_rain_inputs(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options) {
  if (atlas.layers.empty() || atlas.views.empty() || atlas.lights.empty())
    throw std::runtime_error(
        fmt::format("atlas: {} oscillations, {} views, {} lights; expected at least one of each",
                    atlas.layers.size(), atlas.views.size(), atlas.lights.size()));
  if (scene.lights.size() > most_lights)
    throw std::runtime_error(fmt::format("scene: {} lights; expected at most {} with rain",
                                         scene.lights.size(), most_lights));
  expect_same("camera.exposure_s", scene.camera.exposure_s, atlas.exposure_s, "s");
  expect_same("rain.fall_speed_m_s", scene.rain.fall_speed_m_s, atlas.fall_speed_m_s, "m/s");
  expect_same("rain.mean_radius_m", scene.rain.mean_radius_m, atlas.mean_radius_m, "m");
  expect_one_top(atlas);
  if (!(options.max_texel_px > 0) || !std::isfinite(options.max_texel_px))
    throw std::runtime_error(
        fmt::format("max_texel_px = {}; expected a number > 0", options.max_texel_px));
  if (options.finest_level < 0 || options.finest_level >= atlas.levels)
    throw std::runtime_error(
        fmt::format("finest_level = {}; expected 0 .. {}", options.finest_level, atlas.levels - 1));
}

int coarsest_level(const StreakAtlas& atlas) {
  return std::max(0, atlas.levels - 3);
}

int finest_level_needed(const Scene& scene, const StreakAtlas& atlas,
                        const RenderOptions& options) {
  const double focal_px = camera_frame(scene.camera).focal_px;
  // A length across the view grows by 1 / cos of the angle from the axis, most in the corner; a
  // streak may start one cell outside.
  const double corner = std::hypot(scene.camera.width_px, scene.camera.height_px) / 2 / focal_px;
  const double depth_m = std::max(
      nearest_depth_m, nearest_box_depth_m(scene) - atlas.exposure_s * atlas.fall_speed_m_s);
  const double widest_px = focal_px * atlas.pixel_m / depth_m * std::hypot(1, 1.5 * corner);
  const double level = std::floor(std::log2(options.max_texel_px / widest_px));
  return std::max(options.finest_level,
                  static_cast<int>(std::clamp<double>(level, 0, coarsest_level(atlas))));
}

RainUniforms rain_uniforms(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options, const TopHeight& top) {
  const Rain& rain = scene.rain;
  const Eigen::Vector3d size = rain.box_max_m - rain.box_min_m;
  const Eigen::Vector3d corner(rain.box_min_m.x(), rain.box_min_m.y(), rain.box_max_m.z());
  const Eigen::Vector3d grid(top.min_x_m, top.min_y_m, 0);
  double rows_below_path = 0;
  for (const AtlasView& view : atlas.views)
    rows_below_path = std::max(rows_below_path, view.height_px - view.path_bottom_row);
  RainUniforms uniforms;
  uniforms.camera = gpu_camera(scene.camera);
  uniforms.box_corner_m = to_glm(corner - scene.camera.position_m, atlas.pixel_m);
  uniforms.box_size_m = to_glm(size, scene.camera.exposure_s);
  uniforms.velocity_m_s = to_glm(Eigen::Vector3d(0, 0, -rain.fall_speed_m_s), rain.mean_radius_m);
  uniforms.top_grid_m = to_glm(grid - scene.camera.position_m, -1e30);
  uniforms.top_grid_m.z = static_cast<float>(top.texel_m);
  uniforms.cell = to_glm(
      Eigen::Vector3d(atlas.views[0].path_top_row, atlas.cell_width_px, options.max_texel_px),
      rows_below_path);
  const RainSeeds seeds = rain_seeds(rain.seed);
  uniforms.fall = {0, 0, seeds.phase, seeds.place};
  uniforms.counts = {static_cast<int>(drop_count(rain)), static_cast<int>(scene.lights.size()),
                     static_cast<int>(atlas.lights.size()), static_cast<int>(atlas.views.size())};
  const int finest = finest_level_needed(scene, atlas, options);
  uniforms.sizes = {static_cast<int>(atlas.layers.size()), finest,
                    std::max(finest, coarsest_level(atlas)), 0};
  return uniforms;
}

std::vector<std::int32_t> mirrored_layers(const StreakAtlas& atlas) {
  std::vector<std::int32_t> layers;
  for (const AtlasLayer& layer : atlas.layers) {
    const int wanted = fold_angles(0, 0, -90, layer.oscillation).oscillation;
    const auto found = std::find_if(atlas.layers.begin(), atlas.layers.end(),
                                    [&](const AtlasLayer& l) { return l.oscillation == wanted; });
    if (found == atlas.layers.end())
      throw std::runtime_error(fmt::format(
          "atlas: holds oscillation {} without {}; expected both, each is the other's mirror image",
          layer.oscillation, wanted));
    layers.push_back(static_cast<std::int32_t>(found - atlas.layers.begin()));
  }
  return layers;
}

std::vector<glm::vec4> atlas_light_directions(const StreakAtlas& atlas) {
  std::vector<glm::vec4> directions;
  for (const LightDirection& light : atlas.lights) {
    const double v = light.elevation_deg * std::numbers::pi / 180;
    const double h = light.azimuth_deg * std::numbers::pi / 180;
    directions.push_back(to_glm(
        Eigen::Vector3d(std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v)), 0));
  }
  return directions;
}

std::vector<glm::vec4> atlas_views(const StreakAtlas& atlas) {
  std::vector<glm::vec4> views;
  for (const AtlasView& view : atlas.views)
    views.emplace_back(view.elevation_deg, view.path_bottom_row - view.path_top_row, 0, 0);
  return views;
}

}  // namespace pluvia
