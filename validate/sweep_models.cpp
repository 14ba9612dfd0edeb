#include <algorithm>
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

// So many times the drops, where time is measured: a frame of a few hundred streaks costs what any
// frame does.
constexpr double denser = 100;

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
  std::optional<RainRenderer> renderer = {};

  Frame render(const RenderOptions& options) { return rendered(renderer, scene, atlas, options); }
};

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
  return model("flat", "white streaks, as bright in all as the true ones",
               fmt::format("--look white --streak-cd-m2 {:.3g}", radiance),
               {.look = StreakLook::white, .streak_cd_m2 = radiance});
}

std::vector<Model> models_of(Judge& judge, bool quick) {
  std::vector<Model> models = {
      best_white(judge),
      model("a sphere's transfer", "sphere as published in 2006", "--look sphere-published",
            {.look = StreakLook::sphere_published}),
      model("a sphere's transfer", "sphere", "--look sphere", {.look = StreakLook::sphere}),
      model("traced streaks", "nearest", "--lookup nearest", {.lookup = LookupMode::nearest}),
      model("traced streaks", "view-linear", "--lookup view-linear", {}),
      model("traced streaks", "trilinear", "--lookup trilinear",
            {.lookup = LookupMode::trilinear})};
  if (mask_count(judge.atlas.masks) > 0)
    models.push_back(model("refraction", "refraction", "--look refraction --masks DIR",
                           {.look = StreakLook::refraction}));
  if (quick) return models;
  models.push_back(model("traced streaks", "trilinear, the sky's mean",
                         "--lookup trilinear --sky-degree 0",
                         {.lookup = LookupMode::trilinear, .sky_degree = 0}));
  models.push_back(model("traced streaks", "trilinear, 4 far streaks for all",
                         "--lookup trilinear --far-streaks 4",
                         {.far_streaks = 4, .lookup = LookupMode::trilinear}));
  models.push_back(model("billboards of 2010", "billboards, nearest", "",
                         {.path = RainPath::billboards_2010, .lookup = LookupMode::nearest}));
  models.push_back(model("billboards of 2010", "billboards, view-linear", "",
                         {.path = RainPath::billboards_2010}));
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

void time_models(const SweepInputs& inputs, const Progress& progress, Judge& judge,
                 std::vector<Model>& models) {
  Scene dense = judge.scene;
  for (RainSize& size : dense.rain.sizes) size.drops_per_m3 *= inputs.quick ? 1 : denser;
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

using MakeScene = Scene (*)(const StreakAtlas& atlas, const std::string& data_folder);

SweepCurve sweep_scene(const std::string& kind, const std::string& what, MakeScene make_scene,
                       const SweepInputs& inputs, const Progress& progress) {
  const Preset preset = read_preset(inputs.preset_file);
  StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  if (!inputs.masks_folder.empty()) atlas.masks = read_refraction_masks(inputs.masks_folder);
  if (!can_be_judged(atlas)) {
    throw std::runtime_error(inputs.atlas_folder +
                             ": not what models are judged with; expected ten sets, the views 0, "
                             "20 and 40 degrees, 74 lights and a sky");
  }
  if (progress) progress("reference", 0);
  const Scene scene = make_scene(atlas, inputs.data_folder);
  Judge judge = {.atlas = atlas, .scene = scene};
  judge.truth = reference_frame(judge.scene, atlas, reference_options(preset), preset,
                                inputs.quick ? 100 : 1000, inputs.quick ? 6 : 12);
  std::vector<Model> models = models_of(judge, inputs.quick);
  for (Model& model : models) judge_model(judge, model);
  time_models(inputs, progress, judge, models);
  const GlInfo info = judge.renderer->gl_info();
  SweepCurve curve = {
      .name = "models-" + kind,
      .title = "Models of rain, " + what,
      .time_label =
          fmt::format("{} of the rain, {} times the drops [s]",
                      on_processor(info) ? "processor time" : "time", inputs.quick ? 1 : denser),
      .error_label = "relative RMSE of the rain against the reference",
      .text = fmt::format(
          "{} x {} px on {}; {:.3g} drops a cubic metre, 1 to 7 m away, in a box of 8 x 6 x 6 m. "
          "Against the reference tracer with all orders, pixel by pixel, less its noise. FLIP: "
          "mean "
          "LDR-FLIP of the frame; light: of all streaks, over the reference's.",
          scene.camera.width_px, scene.camera.height_px, info.renderer,
          scene.rain.sizes.front().drops_per_m3),
      .whole = "the rain of a frame",
      .standard = lookup_name(RenderOptions{}.lookup)};
  for (Model& model : models) {
    set_times(model.times_s, model.point);
    curve.points.push_back(model.point);
  }
  return curve;
}

}  // namespace

SweepCurve sweep_models_by_day(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene("day", "under a city's sky and a sun", small_frame, inputs, progress);
}

SweepCurve sweep_models_at_night(const SweepInputs& inputs, const Progress& progress) {
  return sweep_scene("night", "under three lamps", small_night_frame, inputs, progress);
}

}  // namespace pluvia
