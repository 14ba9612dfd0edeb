#include "realtime/rain_inputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atlas_lookup.h"
#include "atlas/stroke_coverage.h"
#include "raytrace/depth_of_field.h"
#include "raytrace/rain_fog.h"
#include "raytrace/spherical_harmonics.h"
#include "raytrace/streak_geometry.h"
#include "realtime/far_field.h"
#include "realtime/rain_look.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

// A shader loops over the scene's lights and, for each, over the atlas's: llvmpipe ends a shader
// without a word after 65,535 rounds.
constexpr std::size_t most_lights = 512;

void expect_one_top(const StreakAtlas& atlas) {
  for (const AtlasView& view : atlas.views) {
    if (std::abs(view.path_top_row - atlas.views[0].path_top_row) > 1e-6)
      throw std::runtime_error(
          fmt::format("atlas: view {} deg has path_top_row = {}; expected {} as in view {} deg",
                      view.elevation_deg, view.path_top_row, atlas.views[0].path_top_row,
                      atlas.views[0].elevation_deg));
  }
}

// Distance along the camera's axis of the nearest corner of the rain's box; 1e300 without rain.
double nearest_box_depth_m(const Scene& scene) {
  if (scene.rain.sizes.empty()) return 1e300;
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

// The same, or the least that can be drawn where there are single drops or the camera moves.
double nearest_rain_depth_m(const Scene& scene) {
  const bool anywhere = !scene.drops.empty() || !scene.camera_path.empty();
  return anywhere ? nearest_depth_m : nearest_box_depth_m(scene);
}

// All sizes that fall, those of single drops too.
std::vector<RainSize> all_sizes(const Scene& scene) {
  std::vector<RainSize> sizes = scene.rain.sizes;
  for (const SingleDrop& drop : scene.drops)
    sizes.push_back({.r0_m = drop.r0_m, .velocity_m_s = drop.velocity_m_s});
  return sizes;
}

// A point in the coordinates of a size's top heights on the GPU; w: all drops count.
glm::vec4 in_top(const RainSpace& space, const RainSizeSpace& size, const Eigen::Vector3d& p) {
  const TopHeight& top = space.tops[static_cast<std::size_t>(size.top)];
  return to_glm({p.x() - top.min_x_m, p.y() - top.min_y_m, p.z() - top.lowest_m}, 1e9);
}

}  // namespace

void check_rain_inputs(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options) {
  if (atlas.layers.empty() || atlas.views.empty() || atlas.lights.empty())
    throw std::runtime_error(
        fmt::format("atlas: {} oscillations, {} views, {} lights; expected at least one of each",
                    atlas.layers.size(), atlas.views.size(), atlas.lights.size()));
  if (!atlas.strokes.empty() && !takes_strokes(options.look))
    throw std::runtime_error(
        "strokes: the look takes none; expected sphere, sphere-published or white");
  if (scene.lights.size() > most_lights)
    throw std::runtime_error(fmt::format("scene: {} lights; expected at most {} with rain",
                                         scene.lights.size(), most_lights));
  const bool shows_drops = options.look == StreakLook::refraction;
  for (const RainSize& size : all_sizes(scene)) {
    const double least_s = 2 * size.r0_m / size.velocity_m_s.norm();
    if (shows_drops || scene.camera.exposure_s >= least_s) continue;
    throw std::runtime_error(fmt::format(
        "scene: camera.exposure_s = {:.6g} s; expected {:.2g} s or more, in which a drop of {:.3g} "
        "mm falls its own diameter: less shows drops, not streaks",
        scene.camera.exposure_s, least_s, 2e3 * size.r0_m));
  }
  expect_one_top(atlas);
  if (!(options.max_texel_px > 0) || !std::isfinite(options.max_texel_px))
    throw std::runtime_error(
        fmt::format("max_texel_px = {}; expected a number > 0", options.max_texel_px));
  if (options.sky_degree < 0 || options.sky_degree > highest_harmonic_degree)
    throw std::runtime_error(fmt::format("sky_degree = {}; expected 0 .. {}", options.sky_degree,
                                         highest_harmonic_degree));
  const bool thins = options.far_streaks != 0;
  if (thins && !(options.far_streaks >= 1 && options.far_streaks <= 1e6))
    throw std::runtime_error(
        fmt::format("far_streaks = {}; expected 0, or 1 .. 1e6", options.far_streaks));
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
  double path_m = 0, radius_m = 0;
  for (const RainSize& size : all_sizes(scene)) {
    path_m = std::max(path_m, size.velocity_m_s.norm() * scene.camera.exposure_s);
    radius_m = std::max(radius_m, size.r0_m);
  }
  const double depth_m = std::max(nearest_depth_m, nearest_rain_depth_m(scene) - path_m);
  const double pixel_m = atlas.pixel_m * radius_m / atlas.mean_radius_m;
  const double widest_px = focal_px * pixel_m / depth_m * std::hypot(1, 1.5 * corner);
  const double level = std::floor(std::log2(options.max_texel_px / widest_px));
  return std::max(options.finest_level,
                  static_cast<int>(std::clamp<double>(level, 0, coarsest_level(atlas))));
}

int sky_degree(const StreakAtlas& atlas, const RenderOptions& options) {
  if (options.look != StreakLook::traced) return std::clamp(options.sky_degree, 0, look_sky_degree);
  return std::max(0, std::min(options.sky_degree, atlas.transfer_degree));
}

int sky_cells(const SkyLight& sky) {
  const bool dark = !sky.changes && degree_of(sky) == 0 && !(sky.coefficients.array() > 0).any();
  return dark ? 0 : static_cast<int>(sky.coefficients.rows());
}

int degree_of_cells(int cells) {
  return std::max(0, static_cast<int>(std::lround(std::sqrt(cells))) - 1);
}

std::vector<std::string> sky_notes(const Scene& scene, const StreakAtlas& atlas,
                                   const RenderOptions& options, const SkyLight& sky) {
  if (scene.environment.map_file.empty()) return {};
  std::string note = fmt::format("streaks see the sky in {} spherical harmonics (degree {})",
                                 sky.coefficients.rows(), degree_of(sky));
  if (degree_of(sky) == 0) note = "streaks see the mean of the sky from everywhere";
  if (atlas.transfer_degree < options.sky_degree)
    note += atlas.transfer_degree < 0
                ? ": the atlas has no transfer pictures (transfer_degree in the preset)"
                : fmt::format(": the atlas has them to degree {}", atlas.transfer_degree);
  return {note};
}

std::vector<glm::vec4> gpu_sky(const SkyLight& sky, const RainSpace& space) {
  std::vector<glm::vec4> values;
  for (const RainSizeSpace& size : space.sizes) {
    Eigen::Matrix3d world_from_fall;
    world_from_fall << size.frame.x, size.frame.y, size.frame.z;
    const SkyLight seen = seen_from(sky, world_from_fall);
    for (Eigen::Index i = 0; i < seen.coefficients.rows(); ++i)
      values.push_back(to_glm(seen.coefficients.row(i).transpose(), 0));
  }
  return values;
}

bool has_circles(const Camera& camera) {
  return largest_circle_px(camera) > least_circle_px;
}

RainUniforms rain_uniforms(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options) {
  double rows_below_path = 0;
  for (const AtlasView& view : atlas.views)
    rows_below_path = std::max(rows_below_path, view.height_px - view.path_bottom_row);
  RainUniforms uniforms;
  uniforms.cell = to_glm(
      Eigen::Vector3d(atlas.views[0].path_top_row, atlas.cell_width_px, options.max_texel_px),
      rows_below_path);
  uniforms.counts = {static_cast<int>(atlas.layers.size()), static_cast<int>(scene.lights.size()),
                     static_cast<int>(atlas.lights.size()), static_cast<int>(atlas.views.size())};
  const int finest = finest_level_needed(scene, atlas, options);
  uniforms.sizes = {0, finest, std::max(finest, coarsest_level(atlas)), 0};
  double drawn_per_m = 0;
  for (const RainSize& size : scene.rain.sizes) drawn_per_m += extinction_per_m(size);
  uniforms.air.x = static_cast<float>(air_per_m(scene));
  uniforms.air.y = static_cast<float>(mean_density(scene.rain.density) * drawn_per_m);
  uniforms.density = {scene.rain.density.width, scene.rain.density.height, 0, 0};
  return uniforms;
}

std::vector<GpuRainSize> gpu_rain_sizes(const Scene& scene, const RainSpace& space,
                                        const StreakAtlas& atlas) {
  const StreakGeometry geometry = streak_geometry(atlas);
  std::vector<int> first_height = {0};
  for (const TopHeight& top : space.tops)
    first_height.push_back(first_height.back() + 3 * static_cast<int>(top.texels.size()));
  std::vector<GpuRainSize> sizes;
  for (const RainSizeSpace& size : space.sizes) {
    const SegmentTimes times = segment_times(scene.camera.exposure_s, size.drops.r0_m, geometry);
    const TopHeight& top = space.tops[static_cast<std::size_t>(size.top)];
    GpuRainSize gpu;
    gpu.axis_x = to_glm(size.frame.x, size.cell_m);
    gpu.axis_y = to_glm(size.frame.y, space.local_height_m);
    gpu.axis_z = to_glm(size.frame.z, atlas.pixel_m * size.drops.r0_m / atlas.mean_radius_m);
    gpu.velocity_m_s = to_glm(size.drops.velocity_m_s, size.drops.r0_m);
    gpu.times =
        to_glm({times.each_s, scene.camera.exposure_s, times.each_s / scene.camera.exposure_s},
               size.speed_m_s);
    gpu.top_grid = to_glm({0, 0, top.texel_m}, -1e30);
    const Eigen::Matrix2d& axes = size.density_axes;
    gpu.density_axes = to_glm({axes(0, 0), axes(1, 0), axes(0, 1)}, axes(1, 1));
    gpu.top_layout = {first_height[static_cast<std::size_t>(size.top)], top.width, top.height, 0};
    gpu.run.z = static_cast<std::uint32_t>(times.count);
    sizes.push_back(gpu);
  }
  return sizes;
}

std::vector<float> gpu_top_rows(const TopHeight& top, int first, int end) {
  std::vector<float> heights;
  const auto place = [&](int row) { return top.texels.begin() + std::ptrdiff_t{row} * top.width; };
  for (auto texel = place(first); texel != place(end); ++texel) {
    heights.push_back(static_cast<float>(static_cast<double>(texel->z_m) - top.lowest_m));
    heights.push_back(texel->slope_x);
    heights.push_back(texel->slope_y);
  }
  return heights;
}

std::vector<float> gpu_top_heights(const RainSpace& space) {
  std::vector<float> heights;
  for (const TopHeight& top : space.tops) {
    const std::vector<float> rows = gpu_top_rows(top, 0, top.height);
    heights.insert(heights.end(), rows.begin(), rows.end());
  }
  return heights;
}

void set_frame(const Scene& scene, const RainSpace& space, double time_s, RainUniforms& uniforms,
               std::vector<GpuRainSize>& sizes) {
  const Eigen::Vector3d& camera_m = scene.camera.position_m;
  uniforms.camera = gpu_camera(scene.camera);
  uniforms.box_min_m = to_glm(scene.rain.box_min_m - camera_m, 0);
  uniforms.box_max_m = to_glm(scene.rain.box_max_m - camera_m, 0);
  if (scene.camera.depth_of_field) {
    uniforms.splat_most.y = static_cast<float>(circle_scale_px_m(scene.camera));
    uniforms.splat_most.z = static_cast<float>(1 / scene.camera.depth_of_field->focus_m);
  }
  uniforms.air.z = static_cast<float>(std::clamp(nearest_box_depth_m(scene), 0.0, 1e30));
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const LocalSpace local = local_space(space, static_cast<int>(i), camera_m, time_s);
    sizes[i].run.x = local.phase;
    sizes[i].run.y = local.round;
  }
}

void add_split(const GpuDropGroup& group, std::uint32_t items, std::uint32_t most,
               std::vector<GpuDropGroup>& groups) {
  for (std::uint32_t first = 0; first < items; first += most) {
    groups.push_back(group);
    groups.back().drops.z = first;
    groups.back().drops.w = std::min(most, items - first);
  }
}

namespace {

void add_single_groups(const Scene& scene, const RainSpace& space,
                       const std::vector<GpuRainSize>& sizes, const DropLayers& layers,
                       double time_s, int group_size, std::vector<GpuDropGroup>& groups) {
  for (std::size_t i = 0; i < scene.drops.size(); ++i) {
    GpuDropGroup group = single_group(scene, space, i, time_s);
    group.what.y = layer_of_shape(scene.drops[i].oscillation % layers.sets, layers.shapes_of_set,
                                  static_cast<int>(i));
    add_split(group, sizes[static_cast<std::size_t>(group.what.x)].run.z,
              static_cast<std::uint32_t>(group_size), groups);
  }
}

}  // namespace

std::vector<GpuDropGroup> drop_groups(const Scene& scene, const RainSpace& space,
                                      const std::vector<SizedCell>& cells,
                                      const std::vector<GpuRainSize>& sizes,
                                      const DropLayers& layers, double time_s, int group_size,
                                      double far_streaks) {
  const Eigen::Vector3d& camera_m = scene.camera.position_m;
  std::vector<GpuDropGroup> groups;
  for (const SizedCell& sized : cells) {
    const LocalSpace local = local_space(space, sized.size, camera_m, time_s);
    const auto segments = sizes[static_cast<std::size_t>(sized.size)].run.z;
    const KeptDrops kept = kept_drops(scene, space, sized, far_streaks);
    GpuDropGroup group = cell_group(space, sized.size, local.floor_m, sized.cell, camera_m);
    group.corner_m.w = static_cast<float>(kept.counts_for);
    group.corner_top.w = static_cast<float>(kept.drops);
    add_split(group, static_cast<std::uint32_t>(std::ceil(kept.drops)) * segments,
              static_cast<std::uint32_t>(group_size), groups);
  }
  add_single_groups(scene, space, sizes, layers, time_s, group_size, groups);
  return groups;
}

GpuDropGroup moving_group(const RainSpace& space, const DropMotion& motion, int size_index,
                          const Eigen::Vector3d& camera_m) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const MovingSize& moving = motion.sizes[static_cast<std::size_t>(size_index)];
  const Eigen::Vector3d& low_m = motion.around.low_m;
  return {.corner_m = to_glm(low_m - camera_m, 1),
          .corner_top = in_top(space, size, low_m),
          .drops = {static_cast<std::uint32_t>(moving.first), moving.stream[1], 0, 0},
          .what = {size_index, -1, 0, 0}};
}

std::vector<GpuDropGroup> moving_groups(const Scene& scene, const RainSpace& space,
                                        const DropMotion& motion,
                                        const std::vector<GpuRainSize>& sizes,
                                        const DropLayers& layers, double time_s, int group_size) {
  std::vector<GpuDropGroup> groups;
  for (std::size_t i = 0; i < motion.sizes.size(); ++i)
    add_split(moving_group(space, motion, static_cast<int>(i), scene.camera.position_m),
              static_cast<std::uint32_t>(motion.sizes[i].count) * sizes[i].run.z,
              static_cast<std::uint32_t>(group_size), groups);
  add_single_groups(scene, space, sizes, layers, time_s, group_size, groups);
  return groups;
}

GpuDropGroup cell_group(const RainSpace& space, int size_index, double floor_m,
                        const RainCell& cell, const Eigen::Vector3d& camera_m) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const Eigen::Vector3d corner(cell.x * size.cell_m, cell.y * size.cell_m, floor_m);
  const FallFrame& frame = size.frame;
  const Eigen::Vector3d place = corner.x() * frame.x + corner.y() * frame.y + corner.z() * frame.z;
  const Eigen::Vector2d density = size.density_origin + size.density_axes * corner.head<2>();
  return {.corner_m = to_glm(place - camera_m, 1),
          .corner_top = in_top(space, size, corner),
          .corner_density = to_glm({density.x(), density.y(), 0}, 0),
          .drops = {cell.keys[0], cell.keys[1], 0, 0},
          .what = {size_index, -1, static_cast<int>(cell.keys[2]), 0}};
}

GpuDropGroup single_group(const Scene& scene, const RainSpace& space, std::size_t i,
                          double time_s) {
  const SingleDrop& drop = scene.drops[i];
  const int size_index = space.single_sizes[i];
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(size_index)];
  const FallFrame& frame = size.frame;
  const Eigen::Vector3d place = drop.centre_m + time_s * drop.velocity_m_s;
  const Eigen::Vector3d corner(place.dot(frame.x), place.dot(frame.y), place.dot(frame.z));
  return {.corner_m = to_glm(place - scene.camera.position_m, 1),
          .corner_top = in_top(space, size, corner),
          .what = {size_index, 0, 0, 0}};
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

std::vector<Eigen::Vector3d> light_vectors(const StreakAtlas& atlas) {
  std::vector<Eigen::Vector3d> vectors;
  for (const LightDirection& light : atlas.lights) {
    const double v = light.elevation_deg * std::numbers::pi / 180;
    const double h = light.azimuth_deg * std::numbers::pi / 180;
    vectors.emplace_back(std::cos(v) * std::cos(h), std::cos(v) * std::sin(h), std::sin(v));
  }
  return vectors;
}

std::vector<glm::vec4> atlas_light_directions(const StreakAtlas& atlas) {
  std::vector<glm::vec4> directions;
  for (const Eigen::Vector3d& light : light_vectors(atlas)) directions.push_back(to_glm(light, 0));
  return directions;
}

std::vector<glm::vec4> gpu_light_rows(const StreakAtlas& atlas) {
  std::vector<glm::vec4> rows;
  std::size_t first = 0;
  for (const LightRow& row : light_rows(atlas)) {
    rows.emplace_back(row.elevation_deg, first, row.entries.size(), 0);
    first += row.entries.size();
  }
  return rows;
}

std::vector<glm::vec4> gpu_light_entries(const StreakAtlas& atlas) {
  std::vector<glm::vec4> entries;
  for (const LightRow& row : light_rows(atlas)) {
    for (const LightRow::Entry& entry : row.entries)
      entries.emplace_back(entry.azimuth_deg, entry.light, entry.mirrored ? 1 : 0, 0);
  }
  return entries;
}

std::vector<glm::vec4> atlas_views(const StreakAtlas& atlas) {
  std::vector<glm::vec4> views;
  for (const AtlasView& view : atlas.views)
    views.emplace_back(view.elevation_deg, view.path_bottom_row - view.path_top_row, view.row_px,
                       view.height_px);
  return views;
}

}  // namespace pluvia
