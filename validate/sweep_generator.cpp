#include <algorithm>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "raytrace/brute_force.h"
#include "raytrace/preset.h"
#include "raytrace/streak_accuracy.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_streaks.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

constexpr double exposure_share = 0.1;
constexpr int finer_level = 5;

// A part of one shard, and what it should be.
struct Part {
  StreakRequest request = {};              // the preset's own settings
  std::vector<PictureBatches> truth = {};  // of each light
};

// A run of one setting over all parts, by whatever means.
using Run = std::function<std::vector<StreakImage>(const StreakRequest&)>;

struct Setting {
  SweepPoint point = {};
  Run run = {};
  std::vector<JudgedPicture> pictures = {};
};

std::vector<StreakImage> lights_of_field(const StreakRequest& request) {
  return trace_streak(request).light;
}

// What a preset's tables must say for the whole exposure.
std::string accuracy_keys(const StreakRequest& request) {
  return fmt::format(
      "[accuracy] slices = {}, spans_per_period = {}, base_cells = {}, space_depth = {}, "
      "time_depth = {}, bend_tolerance = {}, motion_tolerance = {}; [light] max_order = {}",
      request.slices, request.spans_per_period, request.field.base_cells, request.field.space_depth,
      request.field.time_depth, request.field.bend_tolerance, request.motion_tolerance,
      request.field.paths.max_order);
}

using Change = std::function<void(StreakRequest&)>;

Setting field_setting(const std::string& series, const std::string& name,
                      const StreakRequest& example, const Change& change) {
  StreakRequest changed = example;
  change(changed);
  return {.point = {.series = series, .setting = name, .flags = accuracy_keys(changed)},
          .run = [change](StreakRequest request) {
            change(request);
            return lights_of_field(request);
          }};
}

void add_single_changes(const StreakRequest& example, std::vector<Setting>& settings) {
  const auto add = [&](const std::string& series, auto value, auto&& set) {
    settings.push_back(field_setting(series, fmt::format("{} {}", series, value), example,
                                     [=](StreakRequest& request) { set(request, value); }));
  };
  for (const double share : {0.125, 0.25, 0.5}) {
    add("slices", std::lround(share * example.slices), [share](StreakRequest& r, long) {
      r.slices = std::max(1, static_cast<int>(std::lround(share * r.slices)));
    });
  }
  for (const int cells : {6, 16}) {
    add("grid: base cells", cells, [](StreakRequest& r, int v) { r.field.base_cells = v; });
  }
  for (const int depth : {1, 2, 4}) {
    add("refinement: space depth", depth, [](StreakRequest& r, int v) { r.field.space_depth = v; });
  }
  for (const int depth : {1, 2}) {
    add("refinement: time depth", depth, [](StreakRequest& r, int v) { r.field.time_depth = v; });
  }
  for (const double tolerance : {1.5, 0.3}) {
    add("bend tolerance", tolerance,
        [](StreakRequest& r, double v) { r.field.bend_tolerance = v; });
  }
  for (const double tolerance : {1.0, 0.5}) {
    add("motion tolerance", tolerance, [](StreakRequest& r, double v) { r.motion_tolerance = v; });
  }
  for (const int order : {1, 2}) {
    add("orders up to", order, [](StreakRequest& r, int v) { r.field.paths.max_order = v; });
  }
}

Setting counted_rays(const std::string& series, const BruteOptions& options) {
  const long rays =
      static_cast<long>(options.replicates) * options.instants * options.rays_per_instant;
  return {.point = {.series = series, .setting = fmt::format("{}, {} rays", series, rays)},
          .run = [options](const StreakRequest& request) {
            return brute_force_streak(request, options).light;
          }};
}

void add_counted_rays(bool quick, std::vector<Setting>& settings) {
  for (const int rays : {500, 2000, 8000}) {
    if (quick && rays > 500) continue;
    settings.push_back(counted_rays("brute force", {.replicates = 4,
                                                    .instants = 64,
                                                    .rays_per_instant = rays,
                                                    .follower = RayFollower::wide}));
  }
  for (const RayFollower follower : {RayFollower::mesh, RayFollower::polished_mesh}) {
    for (const int level : {3, 4, 5, 6, 7}) {
      if (quick && level > 3) continue;
      const bool polished = follower == RayFollower::polished_mesh;
      Setting setting = counted_rays(polished ? "mesh, polished" : "mesh",
                                     {.replicates = 4,
                                      .instants = 16,
                                      .rays_per_instant = quick ? 500 : 4000,
                                      .follower = follower,
                                      .mesh_levels = level});
      setting.point.setting += fmt::format(", {} triangles", 8L << (2 * level));
      settings.push_back(setting);
    }
  }
}

std::vector<Setting> all_settings(const StreakRequest& example, bool quick) {
  std::vector<Setting> settings;
  settings.push_back(field_setting("levels of --error", "preset", example, [](StreakRequest&) {}));
  settings.front().point.series = "preset";
  for (int level = 0; level < (quick ? 2 : finer_level); ++level) {
    settings.push_back(field_setting(
        "levels of --error", fmt::format("level {}", level), example,
        [level](StreakRequest& request) { request = at_accuracy_level(request, level); }));
  }
  if (!quick) add_single_changes(example, settings);
  add_counted_rays(quick, settings);
  return settings;
}

std::vector<ShardKey> chosen_keys(const Preset& preset, bool quick) {
  std::vector<ShardKey> keys = {{.oscillation = 3, .view_elevation_deg = 40},
                                {.oscillation = 8, .view_elevation_deg = 0}};
  if (quick) keys = {{.oscillation = 1, .view_elevation_deg = 40}};
  for (ShardKey& key : keys) key.diameter_um = diameters_of(preset).front();
  return keys;
}

std::vector<Part> chosen_parts(const Preset& preset, bool quick) {
  std::vector<Part> parts;
  for (const ShardKey& key : chosen_keys(preset, quick)) {
    parts.push_back({.request = part_of(shard_request(preset, key), exposure_share)});
  }
  return parts;
}

void judge(const Part& part, const std::vector<StreakImage>& images, Setting& setting) {
  for (std::size_t light = 0; light < images.size(); ++light) {
    setting.pictures.push_back(judged(images[light], part.truth[light]));
  }
}

void measure(const std::vector<Part>& parts, int repeats, const Progress& progress,
             std::vector<Setting>& settings) {
  std::vector<std::function<void(int)>> jobs;
  std::vector<std::vector<std::vector<StreakImage>>> images(settings.size());
  for (std::size_t k = 0; k < settings.size(); ++k) {
    jobs.push_back([&, k](int round) {
      for (const Part& part : parts) {
        auto lights = settings[k].run(part.request);
        if (round == 0) images[k].push_back(std::move(lights));
      }
    });
  }
  const auto times = time_interleaved(jobs, repeats, [&](double share) {
    if (progress) progress("settings", 0.3 + 0.7 * share);
  });
  for (std::size_t k = 0; k < settings.size(); ++k) {
    for (std::size_t p = 0; p < parts.size(); ++p) judge(parts[p], images[k][p], settings[k]);
    set_times(times[k], settings[k].point);
    set_error(settings[k].pictures, settings[k].point);
  }
}

}  // namespace

SweepCurve sweep_generator(const SweepInputs& inputs, const Progress& progress) {
  const Preset preset = read_preset(inputs.preset_file);
  std::vector<Part> parts = chosen_parts(preset, inputs.quick);
  if (progress) progress("finer runs", 0);
  for (Part& part : parts) {
    part.truth = trace_truth(at_accuracy_level(part.request, inputs.quick ? 2 : finer_level));
  }
  std::vector<Setting> settings =
      all_settings(shard_request(preset, chosen_keys(preset, inputs.quick).front()), inputs.quick);
  measure(parts, inputs.repeats, progress, settings);
  const auto shards = preset.oscillations.size() * preset.view_elevations_deg.size();
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  SweepCurve curve = {
      .name = "generator",
      .title = "The generator: " + preset.name,
      .time_label = fmt::format("processor time of {} of {} shard{} [s]", exposure_share,
                                parts.size(), parts.size() == 1 ? "" : "s"),
      .error_label = "relative RMSE of a streak, 90th percentile",
      .text = fmt::format(
          "{} streaks of {} px under cones of {} degrees, against {} finer runs of other seeds "
          "(level "
          "{}), whose noise is taken away. Single changes start from the preset. Brute force and "
          "meshes count rays that leave within a cone: most of their error is noise (in the "
          "table); "
          "what a mesh itself is off is the curve of meshes.",
          parts.size() * parts.front().request.lights.size(), parts.front().request.frame.width_px,
          preset.cone_half_angle_deg, truth_runs, inputs.quick ? 2 : finer_level),
      .whole = fmt::format("a database of {} shards on {} cores", shards, cores),
      .whole_factor = static_cast<double>(shards) /
                      (exposure_share * static_cast<double>(parts.size()) * cores),
      .standard = "preset"};
  for (const Setting& setting : settings) curve.points.push_back(setting.point);
  return curve;
}

}  // namespace pluvia
