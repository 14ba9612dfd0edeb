#include "validate/frame_prices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "validate/frame_composite.h"
#include "validate/picture_comparison.h"

namespace pluvia {
namespace {

constexpr int square_px = 20;

struct Drawn {
  Image rain = {}, background = {}, depth_m = {};
  double cpu_s = 0;  // of all passes
};

Drawn drawn(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options) {
  RainRenderer renderer(scene, atlas, options);
  renderer.render(0);  // the first frame compiles and uploads
  Frame frame = renderer.render(0);
  Drawn result = {.rain = rain_layer(frame.color, frame.background),
                  .background = std::move(frame.background),
                  .depth_m = std::move(frame.depth_m)};
  for (const PassCost& cost : frame.costs) result.cpu_s += cost.cpu_s;
  return result;
}

Image composited(const Scene& scene, const StreakAtlas& atlas, const Drawn& behind) {
  const auto drops = drops_with_sets(scene, set_numbers(atlas), 0);
  return composite_frame(scene, atlas, drops, sky_of(scene, atlas, RenderOptions{}.sky_degree),
                         behind.background, behind.depth_m)
      .rain;
}

struct Variant {
  std::string name = {};
  RenderOptions options = {};
};

// The first is the default.
void add_variants(const Scene& scene, const StreakAtlas& atlas, const std::string& what,
                  const std::vector<Variant>& variants, std::vector<PriceTag>& tags) {
  std::optional<Image> truth;
  double first_s = 0;
  for (const Variant& variant : variants) {
    const Drawn ours = drawn(scene, atlas, variant.options);
    if (!truth) {
      truth = composited(scene, atlas, ours);
      first_s = ours.cpu_s;
    }
    tags.push_back({what + variant.name, "the exact composite of all drops",
                    price_of(square_sums(ours.rain, *truth, square_px)),
                    fmt::format("{:.2f} of the default's CPU time", ours.cpu_s / first_s)});
  }
}

Eigen::Vector3d middle_of(const Scene& scene) {
  const SingleDrop& drop = scene.drops.at(0);
  return drop.centre_m + drop.velocity_m_s * scene.camera.exposure_s / 2;
}

// In place of each sun a lamp in its direction, as bright in the middle of the drop's path.
Scene with_lamps(Scene scene, double distance_m) {
  for (Light& light : scene.lights) {
    light.kind = LightKind::point;
    light.position_m = middle_of(scene) - distance_m * light.direction;
    light.intensity_cd = light.illuminance_lux * distance_m * distance_m;
  }
  return scene;
}

constexpr std::array<int, 2> sets = {3, 7};

DropsScene one_drop(int set, double distance_m) {
  return {.drops = {{20, 0, distance_m, set}}, .suns = suns_of_database};
}

constexpr double seen_from_m = 4;  // drops beside near lamps

// A square pixel; so many of a drop as at 6 m, whatever the size of the streak.
double samples_at(double distance_m) {
  return 30000 * std::pow(distance_m / 6, 2);
}

// Under three lamps, the map a thousandth as bright.
Scene at_night(Scene scene) {
  scene.camera.white_cd_m2 = 10;
  scene.environment.scale_cd_m2 /= 1000;
  const auto lamp = [&](const char* name, const Eigen::Vector3d& position_m,
                        const Eigen::Vector3d& intensity_cd) {
    scene.lights.push_back({.name = name, .position_m = position_m, .intensity_cd = intensity_cd});
  };
  scene.lights.clear();
  lamp("behind the rain", {1.5, 11, 5}, {3000, 2400, 1500});
  lamp("beside it", {-7, 5, 6}, {3000, 2400, 1500});
  lamp("behind the camera", {3, -4, 4}, {2000, 2100, 2400});
  return scene;
}

}  // namespace

std::vector<StreakSums> square_sums(const Image& ours, const Image& truth, int side_px) {
  std::vector<StreakSums> sums;
  const auto square = [&](const Image& image, int x0, int y0) {
    std::vector<float> values;
    for (int y = y0; y < std::min(y0 + side_px, image.height); ++y) {
      const auto first = static_cast<std::ptrdiff_t>(image.channels) * (y * image.width + x0);
      const auto count =
          static_cast<std::ptrdiff_t>(image.channels) * std::min(side_px, image.width - x0);
      values.insert(values.end(), image.values.begin() + first,
                    image.values.begin() + first + count);
    }
    return values;
  };
  for (int y = 0; y < truth.height; y += side_px) {
    for (int x = 0; x < truth.width; x += side_px)
      sums.push_back(streak_sums(square(ours, x, y), square(truth, x, y)));
  }
  return sums;
}

std::vector<PriceTag> drawing_prices(const Scene& scene, const StreakAtlas& atlas) {
  std::vector<PriceTag> tags;
  add_variants(scene, atlas, "",
               {{"a frame as it is drawn", {}},
                {"quads alone", {.widest_splat_px = 0}},
                {"texels up to 0.5 px wide", {.max_texel_px = 0.5}},
                {"texels up to 1 px wide", {.max_texel_px = 1}}},
               tags);
  Scene dense = scene;
  for (RainSize& size : dense.rain.sizes) size.drops_per_m3 *= 8;
  add_variants(dense, atlas, "eight times the drops: ",
               {{"as it is drawn, streaks in any order", {}},
                {"16 far streaks stand for all", {.far_streaks = 16}},
                {"4 far streaks stand for all", {.far_streaks = 4}},
                {"1 far streak stands for all", {.far_streaks = 1}}},
               tags);
  return tags;
}

Table distance_table(const std::string& title, const std::vector<DistanceTag>& tags) {
  Table table = {.title = title,
                 .head = {"approximation", "against", "error, less the noise", "sum of all light"}};
  for (const auto& [approximation, against, distance] : tags)
    table.rows.push_back({approximation, against,
                          percent_text(distance.relative_rmse, distance.standard_error),
                          percent_text(distance.sum, distance.sum_error)});
  return table;
}

std::vector<DistanceTag> near_drop_prices(const StreakAtlas& atlas, const Preset& preset) {
  std::vector<DistanceTag> tags;
  std::optional<RainRenderer> renderer;
  ReferenceOptions options = reference_options(preset);
  options.most_order = preset.field.paths.max_order;
  for (const double distance_m : {6.0, 2.0, 1.0, 0.5, 0.3}) {
    std::vector<StreakFlux> fluxes;
    for (const int set : sets) {
      const DropTrial trial = trial_of(one_drop(set, distance_m), atlas, preset, options,
                                       reference_settings(samples_at(distance_m)));
      const Image ours = rendered(renderer, trial.scene, atlas).rain;
      const auto more = fluxes_of(light_in(ours, trial.masks), trial.truth);
      fluxes.insert(fluxes.end(), more.begin(), more.end());
    }
    tags.push_back({fmt::format("one view for a streak, {} m away", distance_m),
                    "the reference, orders of the database", distance_of(fluxes)});
  }
  return tags;
}

std::vector<std::vector<StreakFlux>> near_lamp_fluxes(const StreakAtlas& atlas,
                                                      const Preset& preset,
                                                      const std::vector<double>& lamps_m,
                                                      double samples_per_px) {
  ReferenceOptions options = reference_options(preset);
  options.most_order = preset.field.paths.max_order;
  const ReferenceSettings settings = reference_settings(samples_per_px);
  ReferenceSettings others = settings;
  others.seed = settings.seed + 1;
  const std::vector<int> numbers = set_numbers(atlas);
  std::vector<std::vector<StreakFlux>> fluxes(lamps_m.size());
  for (const int set : sets) {
    const Scene far = scene_of(one_drop(set, seen_from_m), atlas);
    const auto masks = rectangles_of(far, atlas);
    const auto ours = reference_light(far, preset, numbers, masks, options, settings);
    for (std::size_t k = 0; k < lamps_m.size(); ++k) {
      const auto truth =
          reference_light(with_lamps(far, lamps_m[k]), preset, numbers, masks, options, others);
      for (std::size_t c = 0; c < 3; ++c)
        fluxes[k].push_back({ours.light[0][c], truth.light[0][c],
                             std::hypot(ours.standard_error[0][c], truth.standard_error[0][c])});
    }
  }
  return fluxes;
}

std::vector<DistanceTag> near_lamp_prices(const StreakAtlas& atlas, const Preset& preset) {
  const std::vector<double> lamps_m = {4, 2, 1, 0.5, 0.25};
  const auto fluxes = near_lamp_fluxes(atlas, preset, lamps_m, samples_at(seen_from_m));
  std::vector<DistanceTag> tags;
  for (std::size_t k = 0; k < lamps_m.size(); ++k)
    tags.push_back({fmt::format("a lamp {} m away as its direction at mid path", lamps_m[k]),
                    "the lamp where it is, both by the reference", distance_of(fluxes[k])});
  return tags;
}

Scene small_frame(const StreakAtlas& atlas, const std::string& data_folder) {
  Scene scene;
  scene.camera = {.position_m = {0, 0, 1.6},
                  .target_m = {0, 10, 3},
                  .vertical_fov_deg = 45,
                  .width_px = 320,
                  .height_px = 180,
                  .exposure_s = atlas.exposure_s,
                  .white_cd_m2 = 3000};
  scene.environment = {.map_file = data_folder + "/environments/city.exr", .scale_cd_m2 = 2000};
  // 47 degrees to the left behind the rain, 25 high.
  scene.lights = {{.name = "sun",
                   .kind = LightKind::sun,
                   .direction = Eigen::Vector3d(0.66, -0.62, -0.42).normalized(),
                   .illuminance_lux = {30000, 28000, 25000}}};
  scene.rain.box_min_m = {-4, 1, -1};
  scene.rain.box_max_m = {4, 7, 5};
  scene.rain.sizes = {{.r0_m = atlas.mean_radius_m,
                       .drops_per_m3 = 2,
                       .velocity_m_s = {0, 0, -atlas.fall_speed_m_s}}};
  scene.rain.seed = 2006;
  scene.rain.culling_radius_m = 9;
  scene.rain.local_height_m = 6;
  return scene;
}

Scene small_night_frame(const StreakAtlas& atlas, const std::string& data_folder) {
  return at_night(small_frame(atlas, data_folder));
}

Scene near_frame(const StreakAtlas& atlas, const std::string& data_folder) {
  Scene scene = small_frame(atlas, data_folder);
  scene.camera.vertical_fov_deg = 9;
  scene.camera.width_px = 240;
  scene.camera.height_px = 135;
  scene.rain.box_min_m = {-0.15, 0.15, 1.5};
  scene.rain.box_max_m = {0.15, 0.6, 1.95};
  scene.rain.sizes.front().drops_per_m3 = 1200;
  scene.rain.culling_radius_m = 0.7;
  scene.rain.local_height_m = 0.45;
  return scene;
}

Scene near_night_frame(const StreakAtlas& atlas, const std::string& data_folder) {
  return at_night(near_frame(atlas, data_folder));
}

ReferenceFrame reference_frame(const Scene& scene, const StreakAtlas& atlas,
                               const ReferenceOptions& options, const Preset& preset,
                               double samples_per_px, int passes, std::uint64_t seed) {
  const auto drops = drops_with_sets(scene, set_numbers(atlas), 0);
  const auto traced = make_reference_scene(scene, drops, preset, options);
  const ReferenceSettings settings = {.error = 1e-9,
                                      .learning_passes = 4,
                                      .least_passes = passes,
                                      .most_passes = passes,
                                      .surface_samples = 4,
                                      .samples_per_px = samples_per_px,
                                      .seed = seed};
  ReferenceSums sums = empty_sums(*traced);
  trace_reference(*traced, settings, sums);
  const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
  ReferenceFrame frame = {make_image(sums.width, sums.height, 3),
                          make_image(sums.width, sums.height, 3),
                          make_image(sums.width, sums.height, 1)};
  for (std::size_t i = 0; i < rain.mean.size(); ++i) {
    frame.rain.values[i] = static_cast<float>(rain.mean[i]);
    frame.variance.values[i] = static_cast<float>(rain.variance[i]);
  }
  for (std::size_t i = 0; i < sums.coverage.size(); ++i)
    frame.coverage.values[i] = static_cast<float>(sums.coverage[i] / sums.passes);
  return frame;
}

ReferenceFrame mean_of(const ReferenceFrame& a, const ReferenceFrame& b) {
  ReferenceFrame mean = a;
  for (std::size_t i = 0; i < mean.rain.values.size(); ++i) {
    mean.rain.values[i] = (a.rain.values[i] + b.rain.values[i]) / 2;
    mean.variance.values[i] = (a.variance.values[i] + b.variance.values[i]) / 4;
  }
  for (std::size_t i = 0; i < mean.coverage.values.size(); ++i)
    mean.coverage.values[i] = (a.coverage.values[i] + b.coverage.values[i]) / 2;
  return mean;
}

double noise_of(const ReferenceFrame& frame) {
  return noisy_error(frame.rain, frame.rain, frame.variance).noise;
}

Image with_rain(const Image& background, const Image& rain, float gain) {
  Image sum = background;
  for (std::size_t i = 0; i < sum.values.size(); ++i)
    sum.values[i] = std::max(0.0f, sum.values[i] + gain * rain.values[i]);
  return sum;
}

Distance frame_distance(const Image& rain, const ReferenceFrame& truth) {
  Distance distance = beyond_noise(noisy_error(rain, truth.rain, truth.variance));
  double ours = 0, sum = 0, variance = 0;
  for (std::size_t i = 0; i < rain.values.size(); ++i) {
    ours += static_cast<double>(rain.values[i]);
    sum += static_cast<double>(truth.rain.values[i]);
    variance += static_cast<double>(truth.variance.values[i]);
  }
  distance.sum = ours / sum;
  distance.sum_error = std::sqrt(variance) / std::abs(sum);
  return distance;
}

}  // namespace pluvia
