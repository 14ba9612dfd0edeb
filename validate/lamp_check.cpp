#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "atlas/json_place.h"
#include "validate/checks.h"
#include "validate/frame_composite.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {

namespace {

constexpr LightDirection judged_light = {10, 150};  // as the database names it

// That direction in the world, in words of the picture: behind the drop (the camera looks along
// +y), to the right and a little above.
Eigen::Vector3d toward_lamp() {
  const double up = judged_light.elevation_deg * std::numbers::pi / 180;
  const double behind = (180 - judged_light.azimuth_deg) * std::numbers::pi / 180;
  return {std::cos(up) * std::sin(behind), std::cos(up) * std::cos(behind), std::sin(up)};
}

constexpr double distance_m = 1;
constexpr int size_px = 128;

// Looks at the middle of a fall, so near that two pixels are a texel.
Scene lamp_scene(const StreakAtlas& atlas, const Drop& drop) {
  const Eigen::Vector3d middle = drop.centre_m + atlas.exposure_s / 2 * drop.velocity_m_s;
  Scene scene;
  scene.camera = {.position_m = middle - Eigen::Vector3d(0, distance_m, 0),
                  .target_m = middle,
                  .vertical_fov_deg = 360 / std::numbers::pi *
                                      std::atan(size_px / 4.0 * atlas.pixel_m / distance_m),
                  .width_px = size_px,
                  .height_px = size_px,
                  .exposure_s = atlas.exposure_s};
  constexpr double far_m = 1e4;
  scene.lights = {{.name = "lamp",
                   .position_m = middle + far_m * toward_lamp(),
                   .intensity_cd = Eigen::Vector3d::Constant(far_m * far_m)}};
  return scene;
}

// Of the picture's light, to the right of its middle, in pixels.
double mean_column_px(const Image& image) {
  double sum = 0, moment = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double value = image.at(x, y);
      sum += value;
      moment += value * (x + 0.5 - image.width / 2.0);
    }
  }
  return moment / sum;
}

// Over the drop's radius.
double seen_position(const StreakAtlas& atlas) {
  const Drop drop = {.centre_m = {0, 0, atlas.fall_speed_m_s * atlas.exposure_s / 2},
                     .velocity_m_s = {0, 0, -atlas.fall_speed_m_s},
                     .r0_m = atlas.mean_radius_m,
                     .hit_time_s = std::numeric_limits<double>::max()};
  const Scene scene = lamp_scene(atlas, drop);
  const Image background = make_image(size_px, size_px, 3);
  Image depth_m = make_image(size_px, size_px);
  std::fill(depth_m.values.begin(), depth_m.values.end(), std::numeric_limits<float>::infinity());
  const FrameComposite frame = composite_frame(scene, atlas, {drop}, {}, background, depth_m);
  return mean_column_px(frame.color) / 2 * atlas.pixel_m / atlas.mean_radius_m;
}

}  // namespace

void add_lamp_check(const std::string& database_folder, const StreakAtlas& atlas, Report& report) {
  const std::string name = "frame.lamp_side";
  const bool has_sphere = !atlas.layers.empty() && atlas.layers.front().oscillation == 0;
  if (!has_sphere ||
      std::find(atlas.lights.begin(), atlas.lights.end(), judged_light) == atlas.lights.end()) {
    report.skipped.push_back(name + ": the atlas has no oscillation 0 under " +
                             light_name(judged_light));
    return;
  }
  const std::string file = database_folder + "/manifest.json";
  const auto document = parse_json(file, read_manifest(database_folder).parameters);
  const JsonPlace parameters = {&document, file, "parameters"};
  const Eigen::Vector3d lamp = toward_lamp();
  const double expected = sphere_light_position(positive_at(member(parameters, "refractive_index")),
                                                integer_at(member(parameters, "max_order"), 0, 20),
                                                std::acos(lamp.y())) *
                          lamp.x() / std::hypot(lamp.x(), lamp.z());
  report.checks.push_back(deviation(
      name, seen_position(atlas), expected, 0.5 * atlas.pixel_m / atlas.mean_radius_m, "radii",
      "A rigid sphere falls before a level camera, a lamp behind it on the right: where across the "
      "composited streak its light lies, against closed-form rays, which know neither azimuths nor "
      "mirror images nor an atlas. The bound is half a texel: where in a texel light lies, an "
      "atlas "
      "does not tell. Both are deterministic: no uncertainty."));
}

}  // namespace pluvia
