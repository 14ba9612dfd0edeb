#include <filesystem>
#include <functional>

#include <fmt/format.h>

#include "raytrace/preset.h"
#include "raytrace/streak_accuracy.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_streaks.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

constexpr int model_level = 2, truth_level = 3;  // of raytrace/streak_accuracy.h
constexpr double exposure_share = 0.2;           // of the span: about one period of mode 2

struct Model {
  SweepPoint point = {};
  StreakRequest request = {};
};

// More modes than any preset has: a transverse one of degree 2, and axisymmetric ones of degrees 3
// and 4, each half of the one before. What real drops have beyond the first two was not measured:
// this stands for the size of what is left out.
std::vector<Mode> with_higher_modes(std::vector<Mode> modes) {
  modes.push_back({.n = 2, .m = 1, .amplitude = 0.02, .phase_rad = 1.6});
  modes.push_back({.n = 3, .m = 0, .amplitude = 0.01, .phase_rad = 0.7});
  modes.push_back({.n = 4, .m = 0, .amplitude = 0.005, .phase_rad = 2.1});
  return modes;
}

// The drop at rest or as a sphere, with the first so many of the modes.
StreakRequest reduced(StreakRequest request, bool flattened, std::size_t modes) {
  if (!flattened) request.drop.equilibrium_cos.clear();
  request.drop.modes.resize(modes);
  return request;
}

// No data say what modes beyond two a drop has: those models measure, and are not offered.
std::vector<Model> models_of(const StreakRequest& full, bool quick) {
  struct Kind {
    const char* series;
    const char* name;
    bool flattened;
    std::size_t modes;
    const char* flags;
  };
  const std::vector<Kind> kinds = {
      {"sphere", "sphere", false, 0, "no [drop] equilibrium_file, a set without modes"},
      {"sphere", "sphere, mode (2,0)", false, 1, "no [drop] equilibrium_file, a set of one mode"},
      {"sphere", "sphere, two modes", false, 2, "no [drop] equilibrium_file, a set of two modes"},
      {"shape at rest", "shape at rest", true, 0, "[drop] equilibrium_file, a set without modes"},
      {"shape at rest", "shape at rest, mode (2,0)", true, 1,
       "[drop] equilibrium_file, a set of one mode"},
      {"shape at rest", "shape at rest, two modes", true, 2,
       "[drop] equilibrium_file, a set of two modes"},
      {"shape at rest", "shape at rest, three modes", true, 3, ""},
      {"shape at rest", "shape at rest, four modes", true, 4, ""},
      {"shape at rest", "shape at rest, five modes", true, 5, ""}};
  std::vector<Model> models;
  for (const Kind& kind : kinds) {
    if (quick && kind.modes % 2 == 1) continue;
    models.push_back({{.series = kind.series, .setting = kind.name, .flags = kind.flags},
                      reduced(full, kind.flattened, kind.modes)});
  }
  return models;
}

StreakRequest full_request(const Preset& preset, bool quick) {
  const ShardKey key = {.diameter_um = 3000, .oscillation = 6, .view_elevation_deg = 0};
  StreakRequest request = part_of(shard_request(preset, key), exposure_share);
  request.drop.modes = with_higher_modes(request.drop.modes);
  if (quick) {
    for (std::size_t k = 0; k < request.lights.size() / 8; ++k) {
      request.lights[k] = request.lights[8 * k];
    }
    request.lights.resize(request.lights.size() / 8);
  }
  return request;
}

}  // namespace

SweepCurve sweep_drop(const SweepInputs& inputs, const Progress& progress) {
  const Preset preset = read_preset(inputs.physical_preset_file);
  const StreakRequest full = full_request(preset, inputs.quick);
  if (progress) progress("fullest model", 0);
  const std::vector<PictureBatches> truth =
      trace_truth(at_accuracy_level(full, inputs.quick ? 1 : truth_level));
  std::vector<Model> models = models_of(full, inputs.quick);
  std::vector<std::vector<StreakImage>> images(models.size());
  std::vector<std::function<void(int)>> jobs;
  for (std::size_t k = 0; k < models.size(); ++k) {
    jobs.push_back([&, k](int round) {
      const StreakRequest request =
          at_accuracy_level(models[k].request, inputs.quick ? 0 : model_level);
      auto lights = trace_streak(request).light;
      if (round == 0) images[k] = std::move(lights);
    });
  }
  const auto times = time_interleaved(jobs, inputs.repeats, [&](double share) {
    if (progress) progress("models", 0.2 + 0.8 * share);
  });
  SweepCurve curve = {
      .name = "drop",
      .title = "The drop's model",
      .time_label = fmt::format("processor time of {} of a shard [s]", exposure_share),
      .error_label = "relative RMSE of a streak, 90th percentile",
      .text = fmt::format("{} streaks of a drop of 3 mm in {}, against {} finer runs of the "
                          "fullest model (shape at "
                          "rest, five modes: (2,0) 0.10, (3,1) 0.03, and assumed (2,1) 0.02, (3,0) "
                          "0.01, (4,0) 0.005), "
                          "whose noise is taken away. Settings of the field are those of level {}.",
                          full.lights.size(),
                          std::filesystem::path(inputs.physical_preset_file).filename().string(),
                          truth_runs, inputs.quick ? 0 : model_level),
      .whole = "that part of a shard",
      .standard = "shape at rest, two modes"};
  for (std::size_t k = 0; k < models.size(); ++k) {
    std::vector<JudgedPicture> pictures;
    for (std::size_t light = 0; light < truth.size(); ++light) {
      pictures.push_back(judged(images[k][light], truth[light]));
    }
    set_times(times[k], models[k].point);
    set_error(pictures, models[k].point);
    curve.points.push_back(models[k].point);
  }
  return curve;
}

}  // namespace pluvia
