#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "validate/checks.h"
#include "validate/direct_light.h"
#include "validate/drop_trial.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

// A sixth, a half and five sixths of the way from one height of the database's lights to the next;
// azimuths go with the bearings of the drops.
constexpr std::array<SunDirection, 3> suns_between = {{{13, 140}, {40, 103}, {67, 61}}};

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

// A drop anywhere in each of 4 x 4 fields (Kronecker points), 3 to 6 m away; bearings in whole
// degrees, for its light is traced for the very directions, too.
DropsScene drops_between() {
  DropsScene scene = {.suns = suns_between};
  for (int i = 0; i < 16; ++i) {
    const double x = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
    const double y = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    const double z = std::fmod(0.6180339887498949 * i, 1.0);
    scene.drops.push_back({10 * (i / 4) + 2 + 6 * x, std::round(10.5 * (i % 4 - 2) + 2 + 6.5 * y),
                           3 * std::exp2(z), 1 + i % 9});
  }
  return scene;
}

// Settings of raytrace/streak_accuracy.h: pictures of many lights within 12 %, light within 1 %.
constexpr int direct_accuracy = 1;

const std::array<std::pair<LookupMode, const char*>, 3> lookups = {
    {{LookupMode::nearest, "the nearest view and light"},
     {LookupMode::view_linear, "view-linear: two views, the nearest light"},
     {LookupMode::trilinear, "trilinear: two views, four lights"}}};

struct Judge {
  const Preset& preset;
  const StreakAtlas& atlas;
  Report& report;
  std::optional<RainRenderer> renderer = {};
  Table prices = {.title = "Drop by drop against the reference: what each shortcut costs",
                  .head = {"drops and lights", "light of each streak", "error of the streaks",
                           "sum of all light over the reference's"}};

  Image real_time(const Scene& scene, const RenderOptions& options = {}) {
    return rendered(renderer, scene, atlas, options).rain;
  }

  Distance price(const DropTrial& trial, const Image& picture, const std::string& where,
                 const std::string& what) {
    return price(trial, light_in(picture, trial.masks), where, what);
  }

  Distance price(const DropTrial& trial, const DropLight& light, const std::string& where,
                 const std::string& what) {
    const Distance distance = distance_of(fluxes_of(light, trial.truth));
    prices.rows.push_back(
        {where, what,
         fmt::format("{:.4f} +- {:.4f}", distance.relative_rmse, distance.standard_error),
         fmt::format("{:.4f} +- {:.4f}", distance.sum, distance.sum_error)});
    return distance;
  }

  void judge_database() {
    const DropsScene drops = drops_of_database();
    ReferenceOptions options = reference_options(preset);
    const DropTrial all = trial_of(drops, atlas, preset, options, reference_settings(8000));
    const Image ours = real_time(all.scene);
    const std::string where = "directions of the database";
    price(all, ours, where, "real time, all orders in the reference");
    options.most_order = preset.field.paths.max_order;
    const DropTrial cut = trial_of(drops, atlas, preset, options, reference_settings(15000));
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
    ReferenceOptions options = reference_options(preset);
    options.most_order = preset.field.paths.max_order;
    const DropTrial trial =
        trial_of(drops_between(), atlas, preset, options, reference_settings(3000));
    const std::string where = "between them, orders of the database in both";
    const DropLight direct = direct_light(trial.scene, atlas, preset, direct_accuracy);
    const Distance without_grid = price(trial, direct, where, "traced for the very directions");
    report.checks.push_back(check_of(
        "reference.flux.direct", without_grid, std::hypot(0.03, 2 * hidden_in_noise(without_grid)),
        "Light of 16 drops under three suns, anywhere between the directions that the database "
        "holds, traced for the very directions instead of looked up: against the reference tracer, "
        "less its noise. The bound is the error of a preview's exit field, and of squares four "
        "standard errors of what may hide in the noise."));
    const Distance distance =
        price(trial, real_time(trial.scene), where, "real time, the default lookup");
    for (const auto& [mode, what] : lookups) {
      price(trial, looked_up_light(trial.scene, atlas, mode), where,
            fmt::format("{}, cells of the atlas added up", what));
      price(trial, real_time(trial.scene, {.lookup = mode}), where,
            fmt::format("{}, real time", what));
    }
    price(trial, real_time(trial.scene, {.widest_splat_px = 0}), where, "real time, quads alone");
    price(trial, composite(trial.scene), where, "exact composite");
    price_looks(trial, where);
    report.checks.push_back(check_of(
        "reference.flux.between", distance, grid_price(trial, direct) + 0.03 + 0.02,
        "The same drops in real time: what the database's grid of 20 degrees costs. The bound is "
        "what the grid costs the light that the atlas's cells have by the lookup's rule, against "
        "the light traced for the very directions, and the bounds of reference.flux.direct and "
        "frame.composite."));
  }

  // Relative RMSE of the light of the cells that real time looks up, against `direct`: no
  // renderer, no reference, no noise of either.
  double grid_price(const DropTrial& trial, const DropLight& direct) const {
    const DropLight looked_up = looked_up_light(trial.scene, atlas, RenderOptions{}.lookup);
    std::vector<StreakFlux> fluxes;
    for (std::size_t i = 0; i < direct.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) fluxes.push_back({looked_up[i][c], direct[i][c]});
    }
    return flux_error(fluxes).all.relative_rmse;
  }

  void price_looks(const DropTrial& trial, const std::string& where) {
    price(trial, real_time(trial.scene, {.look = StreakLook::sphere}), where,
          "not traced: spheres with a transfer function");
    price(trial,
          real_time(trial.scene, {.look = StreakLook::sphere_published, .background_share = 0}),
          where, "not traced: spheres as published in 2006, without the background");
    price(trial, fitted_white(trial), where, "not traced: white streaks, as bright as fits best");
  }

  // One radiance for all streaks and suns: that of least squares.
  Image fitted_white(const DropTrial& trial) {
    Image picture = real_time(trial.scene, {.look = StreakLook::white, .streak_cd_m2 = 1});
    double product = 0, square = 0;
    for (const StreakFlux& flux : fluxes_of(light_in(picture, trial.masks), trial.truth)) {
      product += flux.measured * flux.truth;
      square += flux.measured * flux.measured;
    }
    for (float& value : picture.values) value *= static_cast<float>(product / square);
    return picture;
  }

  Image composite(const Scene& scene) const {
    const int width = scene.camera.width_px, height = scene.camera.height_px;
    Image far = make_image(width, height, 1);
    std::fill(far.values.begin(), far.values.end(), std::numeric_limits<float>::infinity());
    const auto drops = drops_with_sets(scene, set_numbers(atlas), 0);
    return composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0),
                           make_image(width, height, 3), far)
        .rain;
  }

  void judge_sky() {
    DropsScene drops = drops_between();
    drops.uniform_sky_cd_m2 = {1, 2, 3};
    ReferenceOptions options = reference_options(preset);
    const ReferenceSettings settings = reference_settings(800);
    const DropTrial all = trial_of(drops, atlas, preset, options, settings);
    const Image ours = real_time(all.scene);
    const std::string where = "uniform sky";
    Distance distance = price(all, ours, where, "real time, all orders in the reference");
    price_looks(all, where);
    if (!atlas.rest_from_sky) {
      options.most_order = preset.field.paths.max_order;
      distance = price(trial_of(drops, atlas, preset, options, settings), ours, where,
                       fmt::format("real time, orders 0 to {} in both", options.most_order));
    }
    report.checks.push_back(check_of(
        "reference.flux.sky", distance, 0.01,
        "Light of 16 drops under a uniform sky, seen from anywhere between the database's views: "
        "real time against the reference tracer with all orders, or with those of the database "
        "where the atlas was packed with --orders-only, less the reference's noise. The bound is "
        "the error of a preview's exit field."));
  }
};

}  // namespace

void add_reference_checks(const Preset& preset, const StreakAtlas& atlas, const Progress& progress,
                          Report& report) {
  const auto step = [&](const char* what, double share) {
    if (progress) progress(what, share);
  };
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
