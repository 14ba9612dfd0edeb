#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "validate/checks.h"
#include "validate/drop_by_drop.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

// Behind the drop, at its side, in front: the three ways in which a lamp makes a streak.
constexpr std::array<SunDirection, 3> suns_of_database = {{{10, 150}, {30, 110}, {50, 50}}};

// A sixth, a half and five sixths of the way from one height of the database's lights to the next;
// azimuths go with the bearings of the drops.
constexpr std::array<SunDirection, 3> suns_between = {{{13.3, 140}, {40, 103}, {66.7, 61}}};

DropsScene drops_of_database() {
  DropsScene scene = {.suns = suns_of_database};
  for (const double view_deg : {0, 20, 40}) {
    for (const double bearing_deg : {-20, 0, 20}) {
      const int set = 1 + static_cast<int>(scene.drops.size());
      scene.drops.push_back({view_deg, bearing_deg, 6, set});
    }
  }
  return scene;
}

// A drop anywhere in each of 4 x 4 fields (Kronecker points), 3 to 6 m away.
DropsScene drops_between() {
  DropsScene scene = {.suns = suns_between};
  for (int i = 0; i < 16; ++i) {
    const double x = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
    const double y = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    const double z = std::fmod(0.6180339887498949 * i, 1.0);
    scene.drops.push_back(
        {10 * (i / 4) + 2 + 6 * x, 10.5 * (i % 4 - 2) + 2 + 6.5 * y, 3 * std::exp2(z), 1 + i % 9});
  }
  return scene;
}

ReferenceOptions reference_options(const Preset& preset) {
  return {.refractive_index = bands_of(preset).at(0).refractive_index,
          .cone_half_angle_rad = preset.cone_half_angle_deg * std::numbers::pi / 180};
}

// So many samples a drop and pass, whatever its size in the picture; nothing but black or one
// radiance is behind the drops, which needs no samples.
ReferenceSettings reference_settings(double samples_per_px) {
  return {.error = 1e-9,
          .learning_passes = 4,
          .least_passes = 12,
          .most_passes = 12,
          .surface_samples = 1,
          .samples_per_px = samples_per_px};
}

struct Trial {  // a scene with its reference
  Scene scene = {};
  std::vector<StreakMask> masks = {};
  ReferenceLight truth = {};
};

Trial trial_of(const DropsScene& drops, const StreakAtlas& atlas, const Preset& preset,
               const ReferenceOptions& options, const ReferenceSettings& settings) {
  Trial trial = {.scene = scene_of(drops, atlas)};
  trial.masks = rectangles_of(trial.scene, atlas);
  trial.truth = reference_light(trial.scene, preset, static_cast<int>(atlas.layers.size()),
                                trial.masks, options, settings);
  return trial;
}

// One streak after the other, how far the light is off, less the noise of the reference.
struct Distance {
  double relative_rmse = 0;   // 0 where the noise is as large
  double standard_error = 0;  // of it; where it is 0, what could hide in the noise
  double sum = 1;             // of all light over that of the reference
  double sum_error = 0;
};

Distance beyond_noise(const NoisyError& error) {
  if (error.squared <= error.standard_error) return {0, std::sqrt(error.standard_error)};
  const double root = std::sqrt(error.squared);
  return {root, error.standard_error / (2 * root)};
}

Distance distance_of(const std::vector<StreakFlux>& fluxes) {
  Distance distance = beyond_noise(flux_error(fluxes).all);
  double ours = 0, truth = 0, variance = 0;
  for (const StreakFlux& flux : fluxes) {
    ours += flux.measured;
    truth += flux.truth;
    variance += flux.standard_error * flux.standard_error;
  }
  distance.sum = ours / truth;
  distance.sum_error = std::sqrt(variance) / truth;
  return distance;
}

Check check_of(const std::string& name, const Distance& distance, double bound,
               const std::string& why) {
  Check check = deviation(name, distance.relative_rmse, 0, bound, "relative RMSE", why);
  check.uncertainty = distance.standard_error;
  return check;
}

struct Judge {
  const Preset& preset;
  const StreakAtlas& atlas;
  Report& report;
  std::optional<RainRenderer> renderer = {};
  Table prices = {.title = "Drop by drop against the reference: what each shortcut costs",
                  .head = {"drops and lights", "light of each streak", "error of the streaks",
                           "sum of all light over the reference's"}};

  Image real_time(const Scene& scene, const RenderOptions& options = {}) {
    if (renderer)
      renderer->remake(scene, atlas, options);
    else
      renderer.emplace(scene, atlas, options);
    return renderer->render(0).rain;
  }

  Distance price(const Trial& trial, const Image& picture, const std::string& where,
                 const std::string& what) {
    const Distance distance = distance_of(fluxes_of(light_in(picture, trial.masks), trial.truth));
    prices.rows.push_back(
        {where, what,
         fmt::format("{:.4f} +- {:.4f}", distance.relative_rmse, distance.standard_error),
         fmt::format("{:.4f} +- {:.4f}", distance.sum, distance.sum_error)});
    return distance;
  }

  void judge_database() {
    const DropsScene drops = drops_of_database();
    ReferenceOptions options = reference_options(preset);
    const Trial all = trial_of(drops, atlas, preset, options, reference_settings(8000));
    const Image ours = real_time(all.scene);
    const std::string where = "directions of the database";
    price(all, ours, where, "real time, all orders in the reference");
    options.most_order = preset.field.paths.max_order;
    const Trial cut = trial_of(drops, atlas, preset, options, reference_settings(15000));
    const Distance distance = price(
        cut, ours, where, fmt::format("real time, orders 0 to {} in both", options.most_order));
    report.checks.push_back(check_of(
        "reference.flux.lamps", distance, 0.03,
        "Light of nine drops of nine sets, each under three suns, in directions of view and light "
        "that the database holds: a real-time frame against the reference tracer with the orders "
        "of the database, less the reference's noise. The bound is the error of a preview's "
        "exit field."));
    Check sum = deviation("reference.flux.lamps.sum", distance.sum, 1, 0.02, "relative",
                          "The same light, summed over all streaks and suns. The bound is three of "
                          "the reference's standard errors and 1 % of the exit field.");
    sum.uncertainty = distance.sum_error;
    report.checks.push_back(sum);
    report.checks.push_back(
        check_of("reference.picture",
                 beyond_noise(noisy_error(ours, cut.truth.picture, cut.truth.variance)), 0.05,
                 "The same two pictures, pixel by pixel, less the reference's noise. The bound is "
                 "the sum of "
                 "those of reference.flux.lamps and frame.composite."));
    add_pictures(ours, cut.truth.picture);
  }

  void add_pictures(const Image& ours, const Image& truth) {
    constexpr double white = 0.05;
    report.comparisons.push_back(
        {.title = "Nine drops in real time and traced",
         .text =
             "Streaks of nine oscillations, 6 m away, seen level (top row), from 20 and from 40 "
             "degrees above, under three suns: one red, behind them, one green, beside them, one "
             "blue, before them.",
         .unit = "cd/m^2",
         .picture = {.image = ours, .white = white, .caption = "real time"},
         .reference = {.image = truth, .white = white, .caption = "reference"},
         .gain = 4});
  }

  void judge_between() {
    const Trial trial = trial_of(drops_between(), atlas, preset, reference_options(preset),
                                 reference_settings(3000));
    const std::string where = "between them";
    const Distance distance = price(trial, real_time(trial.scene), where,
                                    "real time, view-linear: two views, the nearest light");
    price(trial, real_time(trial.scene, {.lookup = LookupMode::nearest}), where,
          "nearest view, nearest light");
    price(trial, real_time(trial.scene, {.lookup = LookupMode::trilinear}), where,
          "trilinear: two views, four lights");
    price(trial, real_time(trial.scene, {.widest_splat_px = 0}), where, "view-linear, quads alone");
    price(trial, composite(trial.scene), where, "view-linear, exact composite");
    report.checks.push_back(
        check_of("reference.flux.between", distance, turned_difference(trial),
                 "Light of 16 drops under three suns, anywhere between the directions that the "
                 "database holds: what its grid of 20 degrees costs. The bound is what turning the "
                 "suns by one step of the grid changes in real time."));
  }

  Image composite(const Scene& scene) const {
    const int width = scene.camera.width_px, height = scene.camera.height_px;
    Image far = make_image(width, height, 1);
    std::fill(far.values.begin(), far.values.end(), std::numeric_limits<float>::infinity());
    const auto drops =
        drop_field(scene, make_rain_space(scene), static_cast<int>(atlas.layers.size()), 0);
    return composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
                           make_image(width, height, 3), far)
        .rain;
  }

  // Relative RMSE of the light of streaks between suns 10 degrees to the left and to the right.
  double turned_difference(const Trial& trial) {
    std::array<DropLight, 2> turned;
    for (std::size_t side = 0; side < 2; ++side) {
      DropsScene drops = drops_between();
      for (SunDirection& sun : drops.suns) sun.azimuth_deg += side == 0 ? -10 : 10;
      turned[side] = light_in(real_time(scene_of(drops, atlas)), trial.masks);
    }
    double change = 0, squares = 0;
    for (std::size_t i = 0; i < turned[0].size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        change += std::pow(turned[0][i][c] - turned[1][i][c], 2);
        squares += (std::pow(turned[0][i][c], 2) + std::pow(turned[1][i][c], 2)) / 2;
      }
    }
    return std::sqrt(change / squares);
  }

  void judge_sky() {
    DropsScene drops = drops_between();
    drops.uniform_sky_cd_m2 = {1, 2, 3};
    ReferenceOptions options = reference_options(preset);
    const ReferenceSettings settings = reference_settings(800);
    const Trial all = trial_of(drops, atlas, preset, options, settings);
    const Image ours = real_time(all.scene);
    const std::string where = "uniform sky";
    price(all, ours, where, "real time, all orders in the reference");
    options.most_order = preset.field.paths.max_order;
    const Distance distance =
        price(trial_of(drops, atlas, preset, options, settings), ours, where,
              fmt::format("real time, orders 0 to {} in both", options.most_order));
    report.checks.push_back(check_of(
        "reference.flux.sky", distance, 0.01,
        "Light of 16 drops under a uniform sky, seen from anywhere between the database's views: "
        "real time against the reference tracer with the orders of the database, less the "
        "reference's noise. The bound is the error of a preview's exit field."));
  }
};

bool can_be_judged(const StreakAtlas& atlas) {
  const auto has = [&](int elevation_deg) {
    return std::any_of(atlas.views.begin(), atlas.views.end(),
                       [&](const AtlasView& view) { return view.elevation_deg == elevation_deg; });
  };
  return atlas.layers.size() == 10 && has(0) && has(20) && has(40) &&
         atlas.lights == gn2006_light_directions() && !atlas.layers.front().env.empty();
}

}  // namespace

void add_reference_checks(const Preset& preset, const std::string& atlas_folder,
                          const Progress& progress, Report& report) {
  const auto step = [&](const char* what, double share) {
    if (progress) progress(what, share);
  };
  const StreakAtlas atlas = read_atlas(atlas_folder);
  if (!can_be_judged(atlas)) {
    report.skipped.push_back(
        "drops one by one against the reference: the atlas has not ten sets, the views 0, 20 and "
        "40 degrees, the 74 lights and a uniform sky");
    return;
  }
  const auto start = std::chrono::steady_clock::now();
  Judge judge{preset, atlas, report};
  step("drops by the reference", 0);
  judge.judge_database();
  step("drops by the reference, between the database's lights", 0.7);
  judge.judge_between();
  step("drops by the reference, under a sky", 0.95);
  judge.judge_sky();
  report.tables.push_back(judge.prices);
  report.seeds.emplace_back("drops one by one, reference",
                            fmt::format("{}", ReferenceSettings{}.seed));
  report.timings_s.emplace_back(
      "drops one by one against the reference",
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace pluvia
