#include "validate/fidelity.h"

#include <chrono>
#include <filesystem>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/checks.h"

namespace pluvia {

namespace {

void append(Report& to, const Report& from) {
  const auto add = [](auto& list, const auto& more) {
    list.insert(list.end(), more.begin(), more.end());
  };
  add(to.checks, from.checks);
  add(to.comparisons, from.comparisons);
  add(to.figures, from.figures);
  add(to.plots, from.plots);
  add(to.tables, from.tables);
  add(to.timings_s, from.timings_s);
  add(to.seeds, from.seeds);
  add(to.skipped, from.skipped);
}

std::vector<CheckedFrame> checked_frames(const FidelityInputs& inputs) {
  if (inputs.scene_files.empty()) throw std::runtime_error("no scene; expected one or more");
  std::vector<CheckedFrame> frames;
  std::set<std::string> names;
  for (const std::string& file : inputs.scene_files) {
    const std::string name = std::filesystem::path(file).stem().string();
    if (!names.insert(name).second)
      throw std::runtime_error(
          fmt::format("{}: a second scene \"{}\"; expected names that differ", file, name));
    frames.push_back({.scene_file = file,
                      .time_s = inputs.time_s,
                      .most_width_px = inputs.depth == ReportDepth::quick ? 320 : 0,
                      .prefix = frames.empty() ? "frame" : "frame." + name});
  }
  return frames;
}

// What each approximation costs.
void add_prices(const FidelityInputs& inputs, const Preset& preset, const StreakAtlas& atlas,
                const Progress& progress, Report& report) {
  add_format_prices(atlas, report);
  if (inputs.depth == ReportDepth::quick) return;
  const bool full = inputs.depth == ReportDepth::full;
  const StudyDepth depth = full ? StudyDepth::full : StudyDepth::brief;
  const Preset preview = read_preset(inputs.data_folder + "/presets/preview.toml");
  add_streak_prices(preview, inputs.data_folder, depth, progress, report);
  if (full)
    add_frame_prices(inputs.scene_files.front(), atlas, preset, progress, report);
  else
    report.skipped.push_back(
        "what grids, sizes, degrees of the sky, drawing and nearness cost: pluvia validate --full");
  add_whole_frame_check(preset, atlas, inputs.data_folder, depth, report);
}

// What the page says at its top: no check sees these.
std::vector<std::string> not_covered() {
  return {
      "Refraction of the scene through drops, and shadows: pluvia reference has them.",
      "Drops seen from beyond 80 degrees of elevation.",
      "Polarised light sources.",
      "Diffraction.",
      "Whether real drops oscillate with these amplitudes.",
      "Of the atlas's own sampling: views beyond the last (40 degrees in the preview), lamps that "
      "are no cone of 5 degrees, and one drop size. What the grid of 74 lights and of views costs "
      "is measured: reference.flux.between."};
}

// The database, its atlas, and what depends on both.
Report judge_database(const FidelityInputs& inputs, const StreakAtlas& atlas) {
  Report report;
  add_database_checks(inputs.database_folder,
                      inputs.data_folder + "/factors/garg_nayar_2006_point_factors.csv", report);
  add_coverage_check(inputs.database_folder, report);
  add_atlas_checks(inputs.database_folder, atlas, report);
  add_lamp_check(inputs.database_folder, atlas, report);
  add_gallery(inputs.database_folder, report);
  return report;
}

// Frames, and single drops in them. Progress goes from 0 to 1.
Report judge_frames(const FidelityInputs& inputs, const Preset& preset, const StreakAtlas& atlas,
                    const std::vector<CheckedFrame>& frames, const Progress& progress) {
  const auto part = [&](double begin, double end) {
    return [&progress, begin, end](const std::string& what, double share) {
      progress(what, begin + (end - begin) * share);
    };
  };
  Report report;
  for (const CheckedFrame& checked : frames) {
    progress(checked.prefix, 0);
    add_frame_check(checked, atlas, report);
  }
  if (inputs.depth != ReportDepth::quick)
    add_reference_checks(preset, atlas, part(0.2, 0.7), report);
  add_prices(inputs, preset, atlas, part(0.7, 1), report);
  return report;
}

}  // namespace

Report measure_fidelity(const FidelityInputs& inputs, const Progress& progress) {
  const auto step = [&](const std::string& what, double share) {
    if (progress) progress(what, share);
  };
  const auto start = std::chrono::steady_clock::now();
  const std::vector<CheckedFrame> frames = checked_frames(inputs);
  const bool quick = inputs.depth == ReportDepth::quick;
  const Preset preset = read_preset(inputs.data_folder + "/presets/gn2006.toml");
  // What depends on the caller's files comes first, so that a bad one is told before the long
  // checks, and last in the report, which climbs down the ladder of truth.
  step("real factors", 0);
  const StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  Report database = judge_database(inputs, atlas);
  const Report frame =
      judge_frames(inputs, preset, atlas, frames,
                   [&](const std::string& what, double share) { step(what, 0.02 + 0.38 * share); });

  Report report;
  report.machine = describe_machine();
  report.commands = inputs.commands;
  report.not_covered = not_covered();
  step("sphere", 0.4);
  add_sphere_checks(report);
  step("furnace", 0.45);
  add_energy_check(preset, report);
  add_mesh_check(preset, report);
  if (quick)
    report.skipped.push_back(
        "field.*, reference.*, prices of traced streaks, frames of their full size: the report was "
        "asked to be quick");
  else
    add_field_checks(
        preset, [&](const std::string& what, double share) { step(what, 0.5 + 0.45 * share); },
        report);
  add_streak_checks(
      inputs.database_folder,
      [&](const std::string& what, double share) { step(what, 0.95 + 0.04 * share); }, database);
  append(report, database);
  append(report, frame);
  step("report", 1);
  report.timings_s.emplace_back(
      "all checks",
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return report;
}

}  // namespace pluvia
