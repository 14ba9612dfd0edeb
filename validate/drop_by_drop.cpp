#include "validate/drop_by_drop.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "raytrace/drop_field.h"
#include "raytrace/streak_geometry.h"

namespace pluvia {
namespace {

constexpr double radians = std::numbers::pi / 180;
constexpr double sun_lux = 100;
// The renderer adds up thin streaks in steps of 2^-16 of white, and draws others where a pixel
// could be brighter than 1,000 times white: the dimmest of these streaks are some thousand steps,
// and no pixel is that bright.
constexpr double white_cd_m2 = 0.2;

Eigen::Vector3d downward(double depression_deg, double bearing_deg) {
  const double v = depression_deg * radians, h = bearing_deg * radians;
  return {std::cos(v) * std::sin(h), std::cos(v) * std::cos(h), -std::sin(v)};
}

Light sun_of(const SunDirection& sun, int channel) {
  const double v = sun.elevation_deg * radians, h = sun.azimuth_deg * radians;
  const Eigen::Vector3d toward(std::cos(v) * std::sin(h), -std::cos(v) * std::cos(h), std::sin(v));
  return {.name = fmt::format("sun {}", channel),
          .kind = LightKind::sun,
          .direction = -toward,
          .illuminance_lux = sun_lux * Eigen::Vector3d::Unit(channel)};
}

StreakMask rectangle_of(const StreakPlacement& placed, const StreakAtlas& atlas) {
  constexpr double margin_px = 4;
  const double rows = 2 * atlas.views.at(0).path_top_row + placed.path_rows;
  Eigen::AlignedBox2d box;
  for (const double u : {0.0, static_cast<double>(atlas.cell_width_px)}) {
    for (const double r : {0.0, rows})
      box.extend(placed.origin_px + u * placed.column_px + r * placed.row_px);
  }
  StreakMask mask;
  mask.x0 = static_cast<int>(std::floor(box.min().x() - margin_px));
  mask.y0 = static_cast<int>(std::floor(box.min().y() - margin_px));
  mask.width = static_cast<int>(std::ceil(box.max().x() + margin_px)) - mask.x0;
  mask.height = static_cast<int>(std::ceil(box.max().y() + margin_px)) - mask.y0;
  mask.touched.assign(static_cast<std::size_t>(mask.width * mask.height), true);
  return mask;
}

bool inside(const StreakMask& mask, const Camera& camera) {
  return mask.x0 >= 0 && mask.y0 >= 0 && mask.x0 + mask.width <= camera.width_px &&
         mask.y0 + mask.height <= camera.height_px;
}

bool apart(const StreakMask& a, const StreakMask& b) {
  return a.x0 + a.width <= b.x0 || b.x0 + b.width <= a.x0 || a.y0 + a.height <= b.y0 ||
         b.y0 + b.height <= a.y0;
}

// Of every mask and channel: the light of all passes so far, summed.
std::vector<double> light_so_far(const ReferenceSums& sums, const std::vector<StreakMask>& masks) {
  std::vector<double> light;
  for (const StreakMask& mask : masks) {
    Eigen::Array3d sum = {0, 0, 0};
    for (int i = 0; i < mask.width * mask.height; ++i) {
      const int x = mask.x0 + i % mask.width, y = mask.y0 + i / mask.width;
      const auto pixel = static_cast<std::size_t>(y * sums.width + x);
      const Eigen::Map<const Eigen::Array3d> rain(&sums.rain[3 * pixel]);
      const Eigen::Map<const Eigen::Array3d> background(&sums.surface[3 * pixel]);
      sum += rain + sums.coverage[pixel] * background / sums.passes;
    }
    light.insert(light.end(), {sum.x(), sum.y(), sum.z()});
  }
  return light;
}

struct PassSums {  // over the passes, of each of their values
  std::vector<double> last = {}, sum = {}, squares = {};

  void add(const std::vector<double>& so_far) {
    for (auto* values : {&last, &sum, &squares}) values->resize(so_far.size(), 0.0);
    for (std::size_t i = 0; i < so_far.size(); ++i) {
      const double value = so_far[i] - last[i];
      sum[i] += value;
      squares[i] += value * value;
    }
    last = so_far;
  }
};

void keep_pictures(const ReferenceSums& sums, ReferenceLight& result) {
  const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
  result.picture = result.variance = make_image(sums.width, sums.height, 3);
  for (std::size_t i = 0; i < rain.mean.size(); ++i) {
    const double hidden = sums.coverage[i / 3] / sums.passes * sums.surface[i] / sums.passes;
    result.picture.values[i] = static_cast<float>(rain.mean[i] + hidden);
    result.variance.values[i] = static_cast<float>(rain.variance[i]);
  }
}

}  // namespace

Scene scene_of(const DropsScene& drops, const StreakAtlas& atlas) {
  Scene scene;
  scene.camera = {.position_m = {0, 0, 0},
                  .target_m = downward(20, 0),
                  .vertical_fov_deg = 60,
                  .width_px = 256,
                  .height_px = 256,
                  .exposure_s = atlas.exposure_s,
                  .white_cd_m2 = white_cd_m2};
  const Eigen::Vector3d velocity_m_s(0, 0, -atlas.fall_speed_m_s);
  for (const SeenDrop& drop : drops.drops) {
    const Eigen::Vector3d middle_m =
        drop.distance_m * downward(drop.view_elevation_deg, drop.bearing_deg);
    scene.drops.push_back({.centre_m = middle_m - velocity_m_s * atlas.exposure_s / 2,
                           .r0_m = atlas.mean_radius_m,
                           .velocity_m_s = velocity_m_s,
                           .oscillation = drop.oscillation});
  }
  scene.environment.uniform_cd_m2 = drops.uniform_sky_cd_m2;
  if (!drops.uniform_sky_cd_m2.isZero(0)) return scene;
  for (std::size_t i = 0; i < drops.suns.size(); ++i)
    scene.lights.push_back(sun_of(drops.suns[i], static_cast<int>(i)));
  return scene;
}

std::vector<StreakMask> rectangles_of(const Scene& scene, const StreakAtlas& atlas) {
  const auto drops = drops_with_sets(scene, set_numbers(atlas), 0);
  std::vector<StreakMask> masks;
  for (const Drop& drop : drops) {
    const auto placed = place_streak(scene, drop, streak_geometry(atlas));
    if (!placed) throw std::runtime_error(fmt::format("drop {} is not in view", drop.id));
    const StreakMask mask = rectangle_of(*placed, atlas);
    if (!inside(mask, scene.camera))
      throw std::runtime_error(fmt::format("drop {}: a streak leaves the picture", drop.id));
    for (const StreakMask& other : masks) {
      if (!apart(mask, other))
        throw std::runtime_error(
            fmt::format("drop {}: a streak beside another; expected them apart", drop.id));
    }
    masks.push_back(mask);
  }
  return masks;
}

ReferenceLight reference_light(const Scene& scene, const Preset& preset,
                               const std::vector<int>& sets, const std::vector<StreakMask>& masks,
                               const ReferenceOptions& options, const ReferenceSettings& settings) {
  const auto drops = drops_with_sets(scene, sets, 0);
  const auto traced = make_reference_scene(scene, drops, preset, options);
  ReferenceSums sums = empty_sums(*traced);
  PassSums passes;
  trace_reference(*traced, settings, sums, [&](const ReferenceSums& now, const ReferenceErrors&) {
    if (now.passes > 0) passes.add(light_so_far(now, masks));
  });
  ReferenceLight result = {.passes = sums.passes};
  const double n = sums.passes;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    auto& light = result.light.emplace_back();
    auto& error = result.standard_error.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      light[c] = passes.sum[3 * i + c] / n;
      const double spread = passes.squares[3 * i + c] - n * light[c] * light[c];
      error[c] = std::sqrt(std::max(0.0, spread) / (n * (n - 1)));
    }
  }
  keep_pictures(sums, result);
  return result;
}

DropLight light_in(const Image& picture, const std::vector<StreakMask>& masks) {
  DropLight light;
  for (const StreakMask& mask : masks) {
    auto& sum = light.emplace_back();
    for (int i = 0; i < mask.width * mask.height; ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] += static_cast<double>(
            picture.at(mask.x0 + i % mask.width, mask.y0 + i / mask.width, static_cast<int>(c)));
    }
  }
  return light;
}

std::vector<StreakFlux> fluxes_of(const DropLight& ours, const ReferenceLight& truth) {
  std::vector<StreakFlux> fluxes;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      fluxes.push_back({ours[i][c], truth.light[i][c], truth.standard_error[i][c]});
  }
  return fluxes;
}

}  // namespace pluvia
