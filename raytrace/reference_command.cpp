#include "raytrace/reference_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "atlas/flag_values.h"
#include "raytrace/moving_parts.h"
#include "raytrace/process_time.h"
#include "raytrace/reference_files.h"

namespace pluvia {
namespace {

constexpr int most_side_px = 16384;  // as scenes may ask for

// Saves sums often enough that a kill costs little, and seldom enough that saving takes at most a
// twentieth of the time.
struct Saver {
  using Clock = std::chrono::steady_clock;
  const std::string& file;
  const std::string& fingerprint;
  Clock::time_point saved = Clock::now();
  Clock::duration took = {};

  void operator()(const ReferenceSums& sums) {
    const auto start = Clock::now();
    if (start - saved < 20 * took) return;
    write_sums(file, fingerprint, sums);
    saved = Clock::now();
    took = saved - start;
  }
};

void shrink(Camera& camera, int width_px) {
  if (width_px == 0) return;
  const double scale = static_cast<double>(width_px) / camera.width_px;
  const double height_px = std::max(1.0, std::round(scale * camera.height_px));
  if (height_px > most_side_px)
    throw std::runtime_error(fmt::format("--width-px {}: {:.0f} rows; expected at most {}",
                                         width_px, height_px, most_side_px));
  camera.height_px = static_cast<int>(height_px);
  camera.width_px = width_px;
}

std::unique_ptr<ReferenceScene> read_reference_scene(const ReferenceFlags& flags,
                                                     ReferenceSummary& summary) {
  const double time_s = flags.start_s + static_cast<double>(flags.frame) / flags.frames_per_s;
  Scene scene = scene_at(read_scene(flags.scene), time_s);
  const Preset preset = read_preset(flags.preset);
  // The drops are those of the frame in the scene's own size: its shape decides about them.
  std::vector<int> sets = preset.oscillations;
  std::sort(sets.begin(), sets.end());
  const std::vector<Drop> drops = drops_with_sets(scene, sets, time_s);
  shrink(scene.camera, flags.width_px);
  summary.left_splashes = scene.splashes.has_value();
  ReferenceOptions options = flags.options;
  options.refractive_index = mean_refractive_index(preset);
  const double cone_deg =
      flags.cone_half_angle_deg > 0 ? flags.cone_half_angle_deg : preset.cone_half_angle_deg;
  if (cone_deg == 0)
    throw std::runtime_error(flags.preset +
                             ": light.cone_half_angle_deg = 0; expected a cone, or "
                             "--cone-half-angle-deg: no ray meets a point");
  options.cone_half_angle_rad = cone_deg * std::numbers::pi / 180;
  try {
    return make_reference_scene(scene, drops, preset, options);
  } catch (const std::exception& error) {  // also a drop of which the preset's tables know nothing
    throw std::runtime_error(flags.scene + ": " + error.what());
  }
}

// 1 when the error that is asked for is there: variance falls with the number of passes.
double share_done(const ReferenceSettings& settings, const ReferenceSums& sums,
                  const ReferenceErrors& errors) {
  const auto share = [](double error, double found) {
    return found > error ? std::pow(error / found, 2) : 1;
  };
  double by_rain = share(settings.error, errors.rain);
  if (errors.rain >= 1)
    by_rain = std::max(by_rain, share(least_rain * settings.error, errors.rain_noise));
  const double by_error = std::min(by_rain, share(settings.error, errors.surface));
  const double passes = sums.learned + sums.passes;
  const double by_passes = passes / (settings.learning_passes + settings.least_passes);
  return std::clamp(std::min(by_error, by_passes), 0.0, 0.999);
}

}  // namespace

CLI::App* add_reference(CLI::App& app, ReferenceFlags& flags, const std::string& data_folder) {
  flags.preset = data_folder + "/presets/gn2006.toml";
  CLI::App* command =
      app.add_subcommand("reference", "trace a frame of a scene without any shortcut");
  command->add_option("scene", flags.scene, "scene, TOML")->required();
  command
      ->add_option("--out", flags.out,
                   "picture, EXR: mean and variance, rain alone; FILE.sums beside it, from which a "
                   "killed run goes on")
      ->required();
  command->add_option("--preset", flags.preset, "whose drops and water the rain has")
      ->capture_default_str();
  command->add_option("--frame", flags.frame, "which frame of pluvia render, from 0")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->add_option("--frames-per-s", flags.frames_per_s, "frame rate")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--start-s", flags.start_s, "time of frame 0")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--error", flags.settings.error,
                   "relative RMSE of the rain, and of the picture without, at which it is done; "
                   "what is brighter than white counts as white")
      ->check(finite_range(1e-4, 1))
      ->capture_default_str();
  command->add_option("--budget", flags.settings.budget_s, "seconds after which no pass is begun")
      ->check(finite_range(1e-3, 1e7));
  command
      ->add_option("--cone-half-angle-deg", flags.cone_half_angle_deg,
                   "of lights without a radius, as drops see them; default: the preset's")
      ->check(finite_range(0.05, 30));
  command->add_option("--width-px", flags.width_px, "of the picture, instead of the scene's")
      ->check(CLI::Range(1, most_side_px));
  command->add_flag("--all-shadows", flags.options.all_shadows,
                    "surfaces stop every light, not only those with shadow = true");
  command->add_flag("!--no-emission-in-drops", flags.options.drops_see_emission,
                    "drops do not see surfaces glow: for scenes whose lights stand for them");
  command->add_option("--seed", flags.settings.seed, "of the samples")->capture_default_str();
  command->add_option("--threads", flags.threads, "0: one per core")->check(CLI::Range(0, 1024));
  command->footer(
      "example: pluvia reference data/scenes/one_drop.toml --frame 0 --start-s 0 --width-px 80 "
      "--error 0.2 --out reference.exr");
  return command;
}

ReferenceSummary reference_frame(const ReferenceFlags& flags, const Progress& progress) {
  std::optional<tbb::global_control> limit;
  if (flags.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(flags.threads));
  const double cpu_s = process_cpu_s();
  ReferenceSummary summary;
  const auto scene = read_reference_scene(flags, summary);
  const std::string sums_file = flags.out + ".sums";
  const std::string fingerprint = reference_fingerprint(*scene, flags.settings);
  ReferenceSums sums = empty_sums(*scene);
  if (std::filesystem::exists(sums_file))
    sums = read_sums(sums_file, fingerprint);
  else
    write_sums(sums_file, fingerprint, sums);  // refuses a bad folder before the minutes
  const int found = sums.passes;
  Saver save = {sums_file, fingerprint};
  trace_reference(*scene, flags.settings, sums,
                  [&](const ReferenceSums& now, const ReferenceErrors& errors) {
                    save(now);
                    if (progress)
                      progress(fmt::format("pass {}, error {:.3f}", now.passes, errors.rain),
                               share_done(flags.settings, now, errors));
                  });
  if (sums.passes < 2)
    throw std::runtime_error(
        fmt::format("{}: {} passes in the time; expected 2 or more (a longer --budget)", flags.out,
                    sums.passes));
  write_sums(sums_file, fingerprint, sums);
  write_reference(flags.out, sums);
  if (progress) progress(flags.out, 1);
  summary.drops = scene->drops.drops.size();
  summary.passes = sums.passes;
  summary.new_passes = sums.passes - found;
  summary.errors = estimated_errors(*scene, sums);
  summary.cpu_s = process_cpu_s() - cpu_s;
  return summary;
}

}  // namespace pluvia
