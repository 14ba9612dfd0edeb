#include "validate/fidelity.h"

#include <chrono>

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

// The atlas is let go before the frame reads its own.
void add_packing_checks(const FidelityInputs& inputs, Report& report) {
  const StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  add_atlas_checks(inputs.database_folder, atlas, report);
  add_lamp_check(inputs.database_folder, atlas, report);
  add_format_prices(atlas, report);
}

// What each approximation costs.
void add_prices(const FidelityInputs& inputs, const Preset& preset, const Progress& progress,
                Report& report) {
  const StudyDepth depth = inputs.full ? StudyDepth::full : StudyDepth::brief;
  const Preset preview = read_preset(inputs.data_folder + "/presets/preview.toml");
  add_streak_prices(preview, inputs.data_folder, depth, progress, report);
  const StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  if (!inputs.full) {
    report.skipped.push_back(
        "what grids, sizes, degrees of the sky, drawing and nearness cost: pluvia validate --full");
  } else {
    add_frame_prices(inputs.scene_file, atlas, preset, progress, report);
  }
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

}  // namespace

Report measure_fidelity(const FidelityInputs& inputs, const Progress& progress) {
  const auto step = [&](const std::string& what, double share) {
    if (progress) progress(what, share);
  };
  const auto start = std::chrono::steady_clock::now();
  const Preset preset = read_preset(inputs.data_folder + "/presets/gn2006.toml");
  // What depends on the caller's files comes first, so that a bad one is told before the long
  // checks, and last in the report, which climbs down the ladder of truth.
  Report database, frame;
  step("real factors", 0);
  add_database_checks(inputs.database_folder,
                      inputs.data_folder + "/factors/garg_nayar_2006_point_factors.csv", database);
  add_coverage_check(inputs.database_folder, database);
  add_packing_checks(inputs, database);
  add_gallery(inputs.database_folder, database);
  step("frame", 0.02);
  add_frame_check(inputs.scene_file, inputs.atlas_folder, inputs.time_s, frame);
  add_reference_checks(
      preset, inputs.atlas_folder,
      [&](const std::string& what, double share) { step(what, 0.1 + 0.2 * share); }, frame);
  add_prices(
      inputs, preset, [&](const std::string& what, double share) { step(what, 0.3 + 0.1 * share); },
      frame);

  Report report;
  report.machine = describe_machine();
  report.commands = inputs.commands;
  report.not_covered = not_covered();
  step("sphere", 0.4);
  add_sphere_checks(report);
  step("furnace", 0.45);
  add_energy_check(preset, report);
  add_mesh_check(preset, report);
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
