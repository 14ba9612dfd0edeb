// What the rain pass hands to its shaders: of a scene and an atlas before the first frame, and of
// the rain space for each frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "atlas/streak_atlas.h"
#include "raytrace/drop_motion.h"
#include "raytrace/rain_packets.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "raytrace/sky_light.h"
#include "realtime/gpu_scene.h"
#include "realtime/rain_renderer.h"

namespace pluvia {

struct RainUniforms {  // rain_uniforms.glsl, member by member
  GpuCamera camera = {};
  glm::vec4 camera_m = {};
  glm::vec4 box_min_m = {}, box_max_m = {};
  glm::vec4 cell = {};
  glm::vec4 environment = {};
  glm::vec4 air = {};
  glm::ivec4 counts = {};
  glm::ivec4 sizes = {};
  glm::vec4 splat = {};
  glm::vec4 splat_most = {};
  glm::ivec4 splat_levels = {};
  glm::ivec4 density = {};
};

struct GpuRainSize {  // RainSize of rain_uniforms.glsl
  glm::vec4 axis_x = {}, axis_y = {}, axis_z = {};
  glm::vec4 velocity_m_s = {};
  glm::vec4 times = {};
  glm::vec4 top_grid = {};
  glm::vec4 density_axes = {};
  glm::ivec4 top_layout = {};
  glm::uvec4 run = {};
};

struct GpuDropGroup {  // DropGroup of rain_drops.glsl
  glm::vec4 corner_m = {};
  glm::vec4 corner_top = {};
  glm::vec4 corner_density = {};
  glm::uvec4 drops = {};
  glm::ivec4 what = {};
};

// Throws std::runtime_error for options out of range, an atlas without layers, views or lights, and
// an exposure in which a drop falls less than its own diameter: that is no streak.
void check_rain_inputs(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options);

// A streak has at least four columns, however thin it is: one that straddles two pixels in front of
// a bright lamp goes wrong else (relative RMSE of the street's rain against the exact composite
// 0.013 with four, 0.019 with two, 0.035 with one).
int coarsest_level(const StreakAtlas& atlas);

// The finest level that any streak of the scene can need: the nearest is as near as the rain's box,
// 0.1 m at least, in the picture's corner.
int finest_level_needed(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options);

// To which degree streaks see the environment: what the options ask for, or the atlas's harmonics
// where they end below it; 0, its mean from everywhere, where the atlas has none. A look that is
// not traced has harmonics of its own.
int sky_degree(const StreakAtlas& atlas, const RenderOptions& options);

// Cells of the atlas that a streak mixes for the sky: none in the dark, 1 for a uniform one, else
// its harmonics. degree_of_cells: the degree of so many harmonics.
int sky_cells(const SkyLight& sky);
int degree_of_cells(int cells);

// How streaks are lit by a map, and why not by more of it.
std::vector<std::string> sky_notes(const Scene& scene, const StreakAtlas& atlas,
                                   const RenderOptions& options, const SkyLight& sky);

// [size * cells + l^2 + l + m], in the frame of each size's fall.
std::vector<glm::vec4> gpu_sky(const SkyLight& sky, const RainSpace& space);

// Circles of the lens (raytrace/depth_of_field.h). A smaller one is not seen: it adds a fortieth to
// the variance of a pixel. Up to the other, a thin streak is walked (rain_splat.comp), made wider
// by the circle's variance; farther out of focus it is a quad, with the circle's own shape.
constexpr double least_circle_px = 0.1, widest_walked_circle_px = 0.5;

// Whether any streak of the scene can be seen out of focus.
bool has_circles(const Camera& camera);

// What no frame changes.
RainUniforms rain_uniforms(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options);
std::vector<GpuRainSize> gpu_rain_sizes(const Scene& scene, const RainSpace& space,
                                        const StreakAtlas& atlas);

// The texels of all tops, one after the other: height above the top's lowest, slopes.
// gpu_top_rows: of rows first .. end - 1 of one.
std::vector<float> gpu_top_rows(const TopHeight& top, int first, int end);
std::vector<float> gpu_top_heights(const RainSpace& space);

// What each frame changes: the camera, the box as seen from it, the runs of the sizes.
void set_frame(const Scene& scene, const RainSpace& space, double time_s, RainUniforms& uniforms,
               std::vector<GpuRainSize>& sizes);

// Of the atlas on the GPU: each oscillation set has one, or one for each shape of its streaks
// (atlas/stroke_coverage.h).
struct DropLayers {
  int sets = 1, shapes_of_set = 1;
};

// One for every group_size drops and segments of a cell, and for those of a single drop.
// far_streaks: of RenderOptions.
std::vector<GpuDropGroup> drop_groups(const Scene& scene, const RainSpace& space,
                                      const std::vector<SizedCell>& cells,
                                      const std::vector<GpuRainSize>& sizes,
                                      const DropLayers& layers, double time_s, int group_size,
                                      double far_streaks);

// A group for every `most` of the items: its first, and how many.
void add_split(const GpuDropGroup& group, std::uint32_t items, std::uint32_t most,
               std::vector<GpuDropGroup>& groups);

// Of drops that move by steps: those of every group from `first` of the size on.
GpuDropGroup moving_group(const RainSpace& space, const DropMotion& motion, int size,
                          const Eigen::Vector3d& camera_m);

// Of all of them and of the single drops, as drop_groups.
std::vector<GpuDropGroup> moving_groups(const Scene& scene, const RainSpace& space,
                                        const DropMotion& motion,
                                        const std::vector<GpuRainSize>& sizes,
                                        const DropLayers& layers, double time_s, int group_size);

// The drops of a cell in a slab that begins at floor_m; of a single drop: without first and number
// of its drops, and without the single drop's oscillation set.
GpuDropGroup cell_group(const RainSpace& space, int size, double floor_m, const RainCell& cell,
                        const Eigen::Vector3d& camera_m);
GpuDropGroup single_group(const Scene& scene, const RainSpace& space, std::size_t i, double time_s);

// Per layer, the layer of the mirrored drop.
std::vector<std::int32_t> mirrored_layers(const StreakAtlas& atlas);

// Toward the lights of the atlas: unit, in the drop's frame.
std::vector<Eigen::Vector3d> light_vectors(const StreakAtlas& atlas);
std::vector<glm::vec4> atlas_light_directions(const StreakAtlas& atlas);

// light_rows as the shader reads them: for each row its elevation in degrees, first entry and
// number of entries; for each entry its azimuth in degrees, light and whether it is mirrored.
std::vector<glm::vec4> gpu_light_rows(const StreakAtlas& atlas);
std::vector<glm::vec4> gpu_light_entries(const StreakAtlas& atlas);

std::vector<glm::vec4> atlas_views(
    const StreakAtlas& atlas);  // elevation in degrees, rows of path;
// first row of the cells and their height

}  // namespace pluvia
