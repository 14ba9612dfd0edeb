#include "raytrace/generate_command.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/flag_values.h"
#include "raytrace/scene_subset.h"

namespace pluvia {
namespace {

void refuse_missing_set(const Preset& preset, int oscillation) {
  std::string known;
  for (const OscillationSet& set : preset.sets) {
    if (set.index == oscillation) return;
    known += (known.empty() ? "" : ", ") + std::to_string(set.index);
  }
  throw CLI::ValidationError(
      "--oscillations", fmt::format("{}; expected one of the preset's {}", oscillation, known));
}

void choose_diameters(const std::vector<double>& diameters_mm, Preset& preset) {
  const std::vector<int> known = diameters_of(preset);
  std::vector<int> chosen;
  std::string names;
  for (const int um : known) names += (names.empty() ? "" : ", ") + fmt::format("{}", um / 1000.0);
  for (const double mm : diameters_mm) {
    const auto um = static_cast<int>(std::lround(1000 * mm));
    if (std::abs(um - 1000 * mm) > 1e-6 ||
        std::find(known.begin(), known.end(), um) == known.end()) {
      throw CLI::ValidationError("--diameters-mm",
                                 fmt::format("{}; expected among the preset's {}", mm, names));
    }
    chosen.push_back(um);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  if (preset.physical) preset.physical->diameters_um = chosen;
}

void refuse_views_below(const Preset& preset) {
  for (const int view : preset.view_elevations_deg) {
    if (view >= 0 || preset.physical) continue;
    throw CLI::ValidationError("--views",
                               fmt::format("{}; expected 0 .. 80 for {}", view, preset.name));
  }
}

// Says what is left out, and what that saves.
Preset choose_for_scene(const Preset& preset, const std::string& file, std::string& said) {
  const auto subset = scene_subset(preset, read_scene(file), file);
  for (const SubsetRow& row : subset.rows) {
    said += fmt::format("{:<12} kept     {}\n", row.what, row.kept.empty() ? "none" : row.kept);
    if (!row.left_out.empty()) said += fmt::format("{:<12} left out {}\n", "", row.left_out);
  }
  const auto share = [](long part, long all) {
    return 100 * (1 - static_cast<double>(part) / static_cast<double>(all));
  };
  said += fmt::format(
      "{} of {} shards, {} of {} images: saves {:.0f} % of the images and, at one time for "
      "each shard and band, {:.0f} % of the tracing\n",
      subset.shards, subset.all_shards, subset.images, subset.all_images,
      share(subset.images, subset.all_images), share(subset.tracings, subset.all_tracings));
  return subset.preset;
}

Isa isa_from(const std::string& name) {
  try {
    return isa_from_name(name);
  } catch (const std::runtime_error& error) {
    throw CLI::ValidationError("--isa", error.what());
  }
}

// "i/n", 1 <= i <= n.
ShardShare share_from(const std::string& text) {
  const std::size_t slash = text.find('/');
  ShardShare share;
  const bool whole = slash != std::string::npos &&
                     text.find_first_not_of("0123456789/") == std::string::npos &&
                     CLI::detail::lexical_cast(text.substr(0, slash), share.index) &&
                     CLI::detail::lexical_cast(text.substr(slash + 1), share.count);
  if (whole && share.index >= 1 && share.index <= share.count) return share;
  throw CLI::ValidationError("--shard", fmt::format("{}; expected i/n with 1 <= i <= n", text));
}

}  // namespace

CLI::App* add_generate(CLI::App& app, GenerateFlags& flags) {
  CLI::App* command = app.add_subcommand("generate", "trace a streak database from a preset");
  command->add_option("preset", flags.preset, "preset, TOML")->required();
  command->add_option("--out", flags.out, "folder of the database; a killed run resumes")
      ->required();
  command->add_option("--views", flags.views, "view elevations [deg] instead of the preset's")
      ->delimiter(',')
      ->check(CLI::Range(-80, 80));
  command->add_option("--diameters-mm", flags.diameters_mm, "some of the preset's diameters [mm]")
      ->delimiter(',')
      ->check(finite_range(0.01, 20));
  command->add_option("--oscillations", flags.oscillations, "sets instead of the preset's")
      ->delimiter(',')
      ->check(CLI::Range(0, 99));
  command
      ->add_option("--cone-half-angle-deg", flags.cone_half_angle_deg,
                   "of every light, instead of the preset's; 0: points at infinity")
      ->check(finite_range(0, 0) | finite_range(0.05, 30));
  command
      ->add_option(
          "--error", flags.error,
          "relative RMSE that 9 of 10 streaks of every shard must keep; chooses the settings")
      ->check(finite_range(0.004, 1));
  command->add_option("--isa", flags.isa, "scalar, avx2 or avx512; default: the widest there is");
  command->add_option("--threads", flags.threads, "0: one per core")->check(CLI::Range(0, 1024));
  command->add_option("--for", flags.scene, "scene, TOML: trace only what it can ask for");
  command->add_option_function<std::string>(
      "--shard", [&flags](const std::string& text) { flags.share = share_from(text); },
      "i/n: the share of worker i of n, each with an --out of its own; then pluvia merge");
  command->footer("example: pluvia generate data/presets/preview.toml --views 0 --out db");
  return command;
}

ChosenPreset chosen_preset(const GenerateFlags& flags) {
  ChosenPreset chosen = {.preset = read_preset(flags.preset)};
  Preset& preset = chosen.preset;
  if (!flags.views.empty()) preset.view_elevations_deg = flags.views;
  if (!flags.oscillations.empty()) preset.oscillations = flags.oscillations;
  for (const int oscillation : preset.oscillations) refuse_missing_set(preset, oscillation);
  if (!flags.diameters_mm.empty()) choose_diameters(flags.diameters_mm, preset);
  refuse_views_below(preset);
  if (flags.cone_half_angle_deg) preset.cone_half_angle_deg = *flags.cone_half_angle_deg;
  if (flags.error) preset.target_error = *flags.error;
  if (!flags.isa.empty()) preset.field.isa = isa_from(flags.isa);
  if (!flags.scene.empty()) preset = choose_for_scene(preset, flags.scene, chosen.left_out);
  return chosen;
}

}  // namespace pluvia
