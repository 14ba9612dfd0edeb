#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/refraction_masks.h"
#include "validate/drop_trial.h"
#include "validate/flip.h"
#include "validate/frame_prices.h"
#include "validate/metrics.h"
#include "validate/picture_comparison.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_frames.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

// A scene that models are judged in.
struct ModelScene {
  std::string kind = {}, what = {};  // of the curve's name and title
  std::string drops = {};            // where they are
  Scene (*make)(const StreakAtlas& atlas, const std::string& data_folder) = nullptr;
  bool wide_streaks = false;  // that show what a drop shows; too few for a far field
  // So many times the drops, where time is measured: a frame of a few streaks costs what any frame
  // does.
  double denser = 100;
  double samples_per_px = 1000;  // of the reference
};

struct Model {
  SweepPoint point = {};
  RenderOptions options = {};
  std::vector<double> times_s = {};
};

// A scene, and what it looks like.
struct Judge {
  const StreakAtlas& atlas;
  Scene scene = {};
  ReferenceFrame truth = {};
  double flip_noise = 0;  // mean LDR-FLIP between two halves of the reference
  std::optional<RainRenderer> renderer = {};

  Frame render(const RenderOptions& options) { return rendered(renderer, scene, atlas, options); }
};

constexpr const char* sky_by_harmonics = ", the sky by harmonics";

double sum_of(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(value);
  return sum;
}

// Light that drops take away from what is behind them.
double hidden_light(const ReferenceFrame& truth, const Image& background) {
  double sum = 0;
  for (std::size_t i = 0; i < background.values.size(); ++i)
    sum += static_cast<double>(truth.coverage.values[i / 3]) *
           static_cast<double>(background.values[i]);
  return sum;
}

Model model(const std::string& series, const std::string& setting, const std::string& flags,
            const RenderOptions& options) {
  return {.point = {.series = series, .setting = setting, .flags = flags}, .options = options};
}

// The one radiance with which white streaks have the light of the true ones. A user who cannot
// measure it does worse.
Model best_white(Judge& judge) {
  const Frame unit = judge.render({.look = StreakLook::white, .streak_cd_m2 = 1.0});
  const double light = sum_of(judge.truth.rain) + hidden_light(judge.truth, unit.background);
  const double radiance = std::max(0.0, light / sum_of(unit.rain));
  return model("white", "white streaks, as bright in all as the true ones",
               fmt::format("--look white --streak-cd-m2 {:.3g}", radiance),
               {.look = StreakLook::white, .streak_cd_m2 = radiance});
}

// As published, and as traced; harmonics of the sky or its mean, which billboards have, too.
void add_model_a(const ModelScene& kind, bool quick, std::vector<Model>& models) {
  const auto add = [&](const std::string& what, RenderOptions options, const std::string& flags) {
    const std::string lookup = lookup_name(options.lookup);
    models.push_back(model("A: traced streaks", "A: traced, " + lookup + what,
                           "--lookup " + lookup + flags, options));
  };
  for (const auto lookup : {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear})
    add(sky_by_harmonics, {.lookup = lookup}, "");
  if (quick) return;
  for (const auto lookup : {LookupMode::view_linear, LookupMode::trilinear})
    add(", the sky's mean", {.lookup = lookup, .sky_degree = 0}, " --sky-degree 0");
  for (const double n : {16.0, 4.0, 1.0}) {
    if (kind.wide_streaks) continue;
    add(fmt::format(", {} far streak{} for all", n, n == 1 ? "" : "s"),
        {.far_streaks = n, .lookup = LookupMode::trilinear}, fmt::format(" --far-streaks {}", n));
  }
  for (const auto lookup : {LookupMode::nearest, LookupMode::view_linear})
    models.push_back(model("A: billboards of 2010",
                           fmt::format("A: billboards of 2010, {}", lookup_name(lookup)), "",
                           {.path = RainPath::billboards_2010, .lookup = lookup}));
}

void add_model_c(const ModelScene& kind, bool quick, std::vector<Model>& models) {
  const auto add = [&](int samples, SceneCapture capture) {
    const bool wide = capture == SceneCapture::wide;
    models.push_back(model(
        wide ? "C: refraction, 165 degrees" : "C: refraction",
        fmt::format("C: refraction, {} sample{}{}", samples, samples == 1 ? "" : "s",
                    wide ? ", 165 degrees" : ""),
        fmt::format("--look refraction --masks DIR --persistence {}{}", samples,
                    wide ? " --capture wide" : ""),
        {.look = StreakLook::refraction, .persistence_samples = samples, .capture = capture}));
  };
  constexpr int usual = RenderOptions{}.persistence_samples;
  if (quick || !kind.wide_streaks) return add(usual, SceneCapture::cube);
  for (const int samples : {1, 5, 10, 20, 50}) add(samples, SceneCapture::cube);
  add(50, SceneCapture::wide);
}

std::vector<Model> models_of(const ModelScene& kind, Judge& judge, bool quick) {
  std::vector<Model> models = {
      best_white(judge),
      model("B: a sphere's transfer", "B: sphere as published in 2006", "--look sphere-published",
            {.look = StreakLook::sphere_published}),
      model("B: a sphere's transfer", "B: sphere", "--look sphere", {.look = StreakLook::sphere})};
  add_model_a(kind, quick, models);
  if (mask_count(judge.atlas.masks) > 0) add_model_c(kind, quick, models);
  return models;
}

void judge_model(Judge& judge, Model& model) {
  const Frame frame = judge.render(model.options);
  const Image rain = rain_layer(frame.color, frame.background);
  const Distance distance = frame_distance(rain, judge.truth);
  // What cannot be told from none is told as a bound.
  model.point.error = distance.relative_rmse > 0 ? distance.relative_rmse : distance.standard_error;
  model.point.standard_error = distance.standard_error;
  const Image truth = with_rain(frame.background, judge.truth.rain, 1);
  const double white = judge.scene.camera.white_cd_m2;
  const double flip = ldr_flip(cut_to_screen(truth, white), cut_to_screen(frame.color, white)).mean;
  const double hidden = hidden_light(judge.truth, frame.background);
  model.point.also = {{"FLIP", flip},
                      {"light", (sum_of(rain) + hidden) / (sum_of(judge.truth.rain) + hidden)}};
}

// Where few streaks are, all of them are drawn. What it costs that some stand for others shows in
// the dense rain, beside all of that rain, and adds to what the model is off.
void price_far_streaks(Judge& judge, const Scene& dense, Model& model) {
  double lost = 0;
  if (model.options.far_streaks > 0) {
    RenderOptions all = model.options;
    all.far_streaks = 0;
    const auto rain = [&](const RenderOptions& options) {
      judge.renderer->remake(dense, judge.atlas, options);
      const Frame frame = judge.renderer->render(0);
      return rain_layer(frame.color, frame.background);
    };
    lost = relative_rmse(rain(model.options), rain(all));
  }
  SweepPoint& point = model.point;
  const double error = std::hypot(point.error, lost);
  if (lost > 0) point.standard_error *= point.error / error;
  point.error = error;
  point.also.emplace_back("of it by far streaks", lost);
}

void time_models(const SweepInputs& inputs, const Progress& progress, Judge& judge,
                 const Scene& dense, std::vector<Model>& models) {
  RainRenderer& renderer = *judge.renderer;
  for (int round = 0; round < inputs.repeats; ++round) {
    for (std::size_t k = 0; k < models.size(); ++k) {
      renderer.remake(dense, judge.atlas, models[k].options);
      renderer.render(0);  // compiles
      models[k].times_s.push_back(rain_time_s(renderer.render(0), renderer.gl_info()));
      const double done = round + static_cast<double>(k + 1) / static_cast<double>(models.size());
      if (progress) progress(models[k].point.setting, 0.5 + 0.5 * done / inputs.repeats);
    }
  }
}

// In two halves, to know what FLIP their noise has.
void trace_truth(const ModelScene& kind, const SweepInputs& inputs, const Preset& preset,
                 Judge& judge) {
  const double samples_per_px = kind.samples_per_px / (inputs.quick ? 10 : 1);
  const auto half = [&](std::uint64_t seed) {
    return reference_frame(judge.scene, judge.atlas, reference_options(preset), preset,
                           samples_per_px, inputs.quick ? 3 : 6, seed);
  };
  const ReferenceFrame one = half(1), other = half(2);
  judge.truth = mean_of(one, other);
  const Image background = judge.render({}).background;
  const auto shown = [&](const ReferenceFrame& frame) {
    return cut_to_screen(with_rain(background, frame.rain, 1), judge.scene.camera.white_cd_m2);
  };
  judge.flip_noise = ldr_flip(shown(one), shown(other)).mean;
}

std::string text_of(const ModelScene& kind, const Judge& judge) {
  std::string text = fmt::format(
      "{} x {} px on {}; {}. Against the reference tracer with all orders, pixel by pixel, less "
      "its noise (relative standard error {:.2g}; what cannot be told from none is told as a "
      "bound). FLIP: mean LDR-FLIP of the frame, {:.2g} between two halves of the reference; "
      "light: of all streaks, over the reference's. The law behind a recommendation is that of "
      "noise: among errors near 1, that of no rain at all, it takes the cheapest, and the front "
      "tells more.",
      judge.scene.camera.width_px, judge.scene.camera.height_px, judge.renderer->gl_info().renderer,
      kind.drops, noise_of(judge.truth), judge.flip_noise);
  if (!kind.wide_streaks)
    text +=
        " Where a few far streaks stand for all, what that costs is added to the error in squares, "
        "and not to FLIP and light: of the dense rain that times are of, against all of its "
        "streaks.";
  return text;
}

SweepCurve sweep_scene(const ModelScene& kind, const SweepInputs& inputs,
                       const Progress& progress) {
  const Preset preset = read_preset(inputs.preset_file);
  StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  if (!inputs.masks_folder.empty()) atlas.masks = read_refraction_masks(inputs.masks_folder);
  if (!can_be_judged(atlas)) {
    throw std::runtime_error(inputs.atlas_folder +
                             ": not what models are judged with; expected ten sets, the views 0, "
                             "20 and 40 degrees, 74 lights and a sky");
  }
  if (progress) progress("reference", 0);
  Judge judge = {.atlas = atlas, .scene = kind.make(atlas, inputs.data_folder)};
  trace_truth(kind, inputs, preset, judge);
  std::vector<Model> models = models_of(kind, judge, inputs.quick);
  const double denser = inputs.quick ? 1 : kind.denser;
  Scene dense = judge.scene;
  for (RainSize& size : dense.rain.sizes) size.drops_per_m3 *= denser;
  for (Model& model : models) {
    judge_model(judge, model);
    if (!kind.wide_streaks) price_far_streaks(judge, dense, model);
  }
  time_models(inputs, progress, judge, dense, models);
  SweepCurve curve = {
      .name = "models-" + kind.kind,
      .title = "Models of rain, " + kind.what,
      .time_label =
          fmt::format("{} of the rain, {} times the drops [s]",
                      on_processor(judge.renderer->gl_info()) ? "processor time" : "time", denser),
      .error_label = "relative RMSE of the rain against the reference",
      .text = text_of(kind, judge),
      .whole = "the rain of a frame",
      .standard =
          "A: traced, " + std::string(lookup_name(RenderOptions{}.lookup)) + sky_by_harmonics};
  for (Model& model : models) {
    set_times(model.times_s, model.point);
    curve.points.push_back(model.point);
  }
  return curve;
}

constexpr const char* far_drops = "2 drops a cubic metre, 1 to 7 m away, in a box of 8 x 6 x 6 m";
constexpr const char* near_drops = "drops 0.15 to 0.6 m away, streaks 5 to 18 px wide";

}  // namespace

SweepCurve sweep_models_by_day(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene({.kind = "day",
                      .what = "under a city's sky and a sun",
                      .drops = far_drops,
                      .make = small_frame},
                     inputs, progress);
}

SweepCurve sweep_models_at_night(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene(
      {.kind = "night", .what = "under three lamps", .drops = far_drops, .make = small_night_frame},
      inputs, progress);
}

SweepCurve sweep_near_models_by_day(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene({.kind = "near-day",
                      .what = "near drops under a city's sky and a sun",
                      .drops = near_drops,
                      .make = near_frame,
                      .wide_streaks = true,
                      .denser = 10,
                      .samples_per_px = 100},
                     inputs, progress);
}

SweepCurve sweep_near_models_at_night(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene({.kind = "near-night",
                      .what = "near drops under three lamps",
                      .drops = near_drops,
                      .make = near_night_frame,
                      .wide_streaks = true,
                      .denser = 10,
                      .samples_per_px = 100},
                     inputs, progress);
}

}  // namespace pluvia
