#include "validate/sweep_command.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/flag_values.h"
#include "validate/report_parts.h"
#include "validate/sweep_json.h"
#include "validate/sweep_page.h"

namespace pluvia {
namespace {

struct KnownCurve {
  std::string name = {};
  bool needs_atlas = false;
  SweepCurve (*measure)(const SweepInputs& inputs, const Progress& progress) = nullptr;
  std::string seeds = {};
};

// In the order of the report, the ladder of truth downward.
const std::vector<KnownCurve>& known_curves() {
  static const std::vector<KnownCurve> curves = {
      {"generator", false, sweep_generator,
       "the preset's; of the finer runs the three after it; of counted rays 7"},
      {"mesh", false, sweep_mesh, "1 .. 8"},
      {"drop", false, sweep_drop, "the preset's; of the finer runs the three after it"},
      {"atlas", false, sweep_atlas, "the preset's"},
      {"renderer", true, sweep_renderer, "the scene's"},
      {"models-day", true, sweep_models_by_day, "rain 2006; reference 1 and 2"},
      {"models-night", true, sweep_models_at_night, "rain 2006; reference 1 and 2"},
      {"models-near-day", true, sweep_near_models_by_day, "rain 2006; reference 1 and 2"},
      {"models-near-night", true, sweep_near_models_at_night, "rain 2006; reference 1 and 2"}};
  return curves;
}

std::vector<std::string> names_of_curves() {
  std::vector<std::string> names;
  for (const KnownCurve& curve : known_curves()) names.push_back(curve.name);
  return names;
}

bool is_wanted(const SweepFlags& flags, const std::string& name) {
  return flags.curves.empty() ||
         std::find(flags.curves.begin(), flags.curves.end(), name) != flags.curves.end();
}

std::vector<const KnownCurve*> wanted_curves(const SweepFlags& flags, Sweep& sweep) {
  std::vector<const KnownCurve*> wanted;
  for (const KnownCurve& curve : known_curves()) {
    if (!is_wanted(flags, curve.name)) continue;
    const bool possible = !curve.needs_atlas || !flags.inputs.atlas_folder.empty();
    if (possible) wanted.push_back(&curve);
    if (!possible && !flags.curves.empty()) {
      throw CLI::ValidationError("--atlas", "is required for the curve " + curve.name);
    }
    if (!possible) sweep.skipped.push_back("curve " + curve.name + ": needs --atlas");
  }
  return wanted;
}

Sweep measure(const SweepFlags& flags, const std::string& command, const Progress& progress) {
  Sweep sweep = {.machine = describe_machine(), .commands = {command}};
  const std::vector<const KnownCurve*> wanted = wanted_curves(flags, sweep);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const auto part = [&](const std::string& what, double share) {
      if (!progress) return;
      progress(wanted[k]->name + ": " + what,
               (static_cast<double>(k) + share) / static_cast<double>(wanted.size()));
    };
    SweepCurve curve = wanted[k]->measure(flags.inputs, part);
    mark_front(curve);
    recommend(curve);
    sweep.curves.push_back(curve);
    sweep.seeds.emplace_back("curve " + wanted[k]->name, wanted[k]->seeds);
  }
  return sweep;
}

void write_sweep(const std::string& folder, Sweep sweep) {
  for (const SweepCurve& curve : sweep.curves) {
    const PlotDrawing drawing = draw_plot(sweep_plot(curve));
    if (drawing.svg.empty()) sweep.skipped.push_back(drawing.why_not);
    if (!drawing.svg.empty()) {
      write_file_atomically(folder + "/" + curve.name + ".svg",
                            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n" + drawing.svg);
    }
  }
  write_file_atomically(folder + "/sweep.json", sweep_json(sweep));
  Report report = {.lead = sweep_lead(sweep), .machine = sweep.machine};
  add_sweep(sweep, report);
  write_file_atomically(folder + "/index.html", report_page(report, folder));
}

std::string picks(const SweepFlags& flags, const SweepCurve& curve) {
  std::string text;
  if (flags.budget_s) text += pick_line(curve, pick_by_time(curve, *flags.budget_s));
  if (flags.error) text += pick_line(curve, pick_by_error(curve, *flags.error));
  return text.empty() ? sweep_text(curve) : text;
}

void refuse_unmeasured(const SweepFlags& flags, const Sweep& sweep) {
  for (const std::string& name : flags.curves) {
    const bool there = std::any_of(sweep.curves.begin(), sweep.curves.end(),
                                   [&](const SweepCurve& curve) { return curve.name == name; });
    if (!there) {
      throw std::runtime_error(
          fmt::format("{}: no curve \"{}\"; expected one that was measured", flags.from, name));
    }
  }
}

}  // namespace

CLI::App* add_sweep(CLI::App& app, SweepFlags& flags, const std::string& data_folder) {
  flags.inputs.preset_file = data_folder + "/presets/gn2006.toml";
  flags.inputs.physical_preset_file = data_folder + "/presets/physical.toml";
  flags.inputs.data_folder = data_folder;
  flags.inputs.scene_file = data_folder + "/scenes/street.toml";
  CLI::App* command =
      app.add_subcommand("sweep", "measure error against time, and pick settings by either");
  CLI::Option* const out = command->add_option(
      "--out", flags.out, "folder of sweep.json, a picture of each curve and index.html");
  CLI::Option* const from =
      command->add_option("--from", flags.from, "sweep.json, instead of measuring");
  from->excludes(out);
  command->add_option("--curve", flags.curves, "which ones; without: all of them")
      ->check(CLI::IsMember(names_of_curves()));
  command
      ->add_option("--budget", flags.budget_s,
                   "pick the most accurate setting that takes no longer, such as 5min")
      ->transform(duration_in_seconds());
  command->add_option("--error", flags.error, "pick the cheapest setting that is no farther off")
      ->check(finite_range(0, 1e9));
  command->add_option("--repeats", flags.inputs.repeats, "of each time")
      ->check(CLI::Range(1, 99))
      ->excludes(from)
      ->capture_default_str();
  command->add_flag("--quick", flags.inputs.quick, "fewer and smaller: to try it, not to quote it")
      ->excludes(from);
  command
      ->add_option("--preset", flags.inputs.preset_file,
                   "for generator and atlas: of the kind gn2006")
      ->excludes(from)
      ->capture_default_str();
  command
      ->add_option("--atlas", flags.inputs.atlas_folder,
                   "folder of an atlas, for renderer and models")
      ->excludes(from);
  command
      ->add_option("--masks", flags.inputs.masks_folder,
                   "folder of refraction masks, for models; without: no refraction")
      ->excludes(from);
  command->add_option("--scene", flags.inputs.scene_file, "for renderer")
      ->excludes(from)
      ->capture_default_str();
  command->footer("example: pluvia sweep --atlas atlas --out sweep --budget 5min");
  return command;
}

std::string run_sweep(const SweepFlags& flags, const std::string& command,
                      const Progress& progress) {
  if (flags.out.empty() == flags.from.empty()) {
    throw CLI::ValidationError("--out", "or --from is required");
  }
  Sweep sweep;
  if (flags.from.empty()) {
    make_folder(flags.out);  // before the minutes of measuring
    sweep = measure(flags, command, progress);
    write_sweep(flags.out, sweep);
  } else {
    sweep = read_sweep(flags.from);
    refuse_unmeasured(flags, sweep);
  }
  std::string text;
  for (const SweepCurve& curve : sweep.curves) {
    if (is_wanted(flags, curve.name)) text += picks(flags, curve);
  }
  for (const std::string& skipped : sweep.skipped) text += "skipped: " + skipped + "\n";
  return text;
}

}  // namespace pluvia
