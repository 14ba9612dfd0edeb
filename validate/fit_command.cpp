#include "validate/fit_command.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/flag_values.h"
#include "oscillation/equilibrium.h"
#include "validate/factor_fit.h"
#include "validate/fit_json.h"

namespace pluvia {
namespace {

// "31" is n = 3, m = 1: degrees and orders of one digit.
OutlineModel outline_model(const FitOutlinesFlags& flags) {
  OutlineModel model;
  model.modes.clear();
  for (const std::string& mode : flags.modes) {
    if (std::count(flags.modes.begin(), flags.modes.end(), mode) > 1) {
      throw CLI::ValidationError("--modes", mode + " twice; expected each mode once");
    }
    model.modes.push_back({mode[0] - '0', mode[1] - '0'});
  }
  if (flags.equilibrium_mm) {
    const std::string table = flags.data_folder + "/tables/chuang_beard_1990_cn.csv";
    model.equilibrium_cos =
        equilibrium_cos(read_equilibrium_table(table), 1e-3 * *flags.equilibrium_mm);
  }
  return model;
}

// Throws after writing when the outlines are no drop's.
std::string fit_outlines(const FitOutlinesFlags& flags) {
  const Outlines outlines = read_outlines(flags.outlines);
  const OutlineFit fit = fit_outlines(outlines, outline_model(flags));
  write_outline_fit(flags.out, outlines, fit);
  if (!fit.refusal.empty()) throw std::runtime_error(flags.outlines + ": " + fit.refusal);
  std::string text;
  for (const Estimate& estimate : fit.values) {
    text += fmt::format("{}\n", estimate_line(estimate));
  }
  text += fmt::format("scatter {:.4g} mm, {} of {} points are outliers{}{}\n", fit.scatter_mm,
                      fit.outliers, fit.points,
                      fit.alternatives.empty()
                          ? ""
                          : fmt::format("; {} other drops fit as well", fit.alternatives.size()),
                      fit.converged ? "" : "; not converged");
  return text;
}

// The fits know the drops of 2006: spheres with two modes, one size, one band.
Preset read_gn2006(const std::string& file) {
  Preset preset = read_preset(file);
  if (preset.name == "gn2006") return preset;
  throw CLI::ValidationError("--preset",
                             fmt::format("{}: {}; expected a preset of gn2006", file, preset.name));
}

// Throws after writing when the streaks are no drop's.
std::string fit_streak(const FitStreakFlags& flags, const Progress& progress) {
  Preset preset = read_gn2006(flags.preset);
  const StreakInput input = read_streaks(flags.streaks, flags.lights, flags.view_elevation_deg);
  preset.width_px = input.width_px;
  StreakRequest request = shard_request(preset, {.oscillation = preset.sets.front().index,
                                                 .view_elevation_deg = input.view_elevation_deg});
  request.environment.transfer_degree = -1;  // lights alone are fitted
  if (request.frame.height_px != input.height_px) {
    throw std::runtime_error(fmt::format("{}: {} x {} px; expected {} rows for that width and view",
                                         flags.streaks, input.width_px, input.height_px,
                                         request.frame.height_px));
  }
  const StreakFit fit =
      fit_streak(request, input.streaks, streak_starts(flags.free_phases),
                 {.free_phases = flags.free_phases, .known_level = input.known_level},
                 [&](double share) { progress("fit", share); });
  write_streak_fit(flags.out, flags.streaks, input, fit);
  if (!fit.refusal.empty()) throw std::runtime_error(flags.streaks + ": " + fit.refusal);
  std::string text;
  for (const Estimate& estimate : fit.values) {
    text += fmt::format("{}\n", estimate_line(estimate));
  }
  text += fmt::format("residual {:.1f} % of the pattern, {} streaks traced{}{}\n",
                      100 * fit.residual, fit.traced,
                      fit.alternatives.empty()
                          ? ""
                          : fmt::format("; {} other drops fit as well", fit.alternatives.size()),
                      fit.converged ? "" : "; not converged");
  return text;
}

std::string sets_text(const AmplitudeFit& fit) {
  std::string text;
  for (const SetAmplitudes& set : fit.sets) {
    text += fmt::format("set {}:", set.oscillation);
    for (const Estimate& value : set.values) {
      text += fmt::format(" {};", estimate_line(value));
    }
    text += fmt::format(" rms {:.3f} fitted, {:.3f} judged ({:.3f} with the preset's)\n",
                        set.rms_fitted, set.rms_judged, set.rms_judged_preset);
  }
  text += fmt::format("{} streaks traced, their logarithms good to {:.4f}{}\n", fit.traced,
                      fit.log10_noise, fit.converged ? "" : "; not converged");
  return text;
}

std::string fit_factors(const FitFactorsFlags& flags, const Progress& progress) {
  const Preset preset = read_gn2006(flags.preset);
  const auto factors = read_real_factors(flags.factors);
  const FactorFit fit = fit_factors(preset, factors);
  const AmplitudeFit amplitudes =
      fit_amplitudes(preset.sets, factors, traced_model(preset, factors), {},
                     [&](double share) { progress("tables", share); });
  write_factor_fit(flags.out, fit, amplitudes);
  const FittedValue& cone = fit.cone;
  std::string text;
  text += fmt::format("{} {} (from {})\n", cone.name,
                      cone.identifiable
                          ? fmt::format("{:.3f} +- {:.3f}", cone.value, cone.standard_error)
                          : "is not determined by these factors",
                      cone.start);
  text += fmt::format("rms of log10(ours/theirs) {:.4f}, before {:.4f}{}\n", fit.rms_after,
                      fit.rms_before, fit.converged ? "" : "; not converged");
  return text + sets_text(amplitudes);
}

// "nm" with 2 <= n <= 9, 0 <= m <= n.
CLI::Validator mode_name() {
  const auto check = [](const std::string& text) {
    const bool fits = text.size() == 2 && text[0] >= '2' && text[0] <= '9' && text[1] >= '0' &&
                      text[1] <= text[0];
    return fits ? std::string() : text + "; expected two digits n, m with 2 <= n, m <= n";
  };
  return {check, "NM"};
}

CLI::App* add_fit_outlines(CLI::App& fit, FitOutlinesFlags& flags) {
  CLI::App* command = fit.add_subcommand("outlines", "a drop's oscillation from its outlines");
  command->add_option("file", flags.outlines, "outlines, CSV (docs/fits.md)")->required();
  command->add_option("--modes", flags.modes, "modes to fit, n and m, each once")
      ->delimiter(',')
      ->check(mode_name())
      ->capture_default_str();
  command
      ->add_option("--equilibrium-mm", flags.equilibrium_mm,
                   "oscillate about the resting shape of that diameter, not a sphere")
      ->check(finite_range(0.01, 9));
  command->add_option("--out", flags.out, "JSON to write")->required();
  command->footer("example: pluvia fit outlines data/outlines/synthetic.csv --out fit.json");
  return command;
}

CLI::Validator light_name() {
  const auto check = [](const std::string& text) {
    try {
      parse_light_name(text);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return {check, "light_vEE_hAAA"};
}

CLI::App* add_fit_streak(CLI::App& fit, FitStreakFlags& flags, const std::string& data_folder) {
  CLI::App* command = fit.add_subcommand("streak", "a drop's oscillation from its streaks");
  flags.preset = data_folder + "/presets/preview.toml";
  command->add_option("file", flags.streaks, "shard, EXR; or a picture of linear values")
      ->required();
  command
      ->add_option("--lights", flags.lights,
                   "of the shard (default: all), or the one that lit the picture")
      ->delimiter(',')
      ->check(light_name());
  command->add_option("--view-elevation-deg", flags.view_elevation_deg, "of a picture's camera")
      ->check(CLI::Range(0, 80))
      ->capture_default_str();
  command->add_flag("--free-phases", flags.free_phases, "fit both phases at shutter-open, too");
  command->add_option("--preset", flags.preset, "drop, exposure, light and accuracy of the trials")
      ->capture_default_str();
  command->add_option("--out", flags.out, "JSON to write")->required();
  command->footer(
      "example (after: pluvia generate data/presets/preview.toml --views 0 --oscillations 3 --out "
      "db):\n  pluvia fit streak db/shards/d3200_osc03_v+00.exr --lights "
      "light_v+10_h130,light_v+50_h110 --out fit.json");
  return command;
}

CLI::App* add_fit_factors(CLI::App& fit, FitFactorsFlags& flags, const std::string& data_folder) {
  CLI::App* command =
      fit.add_subcommand("factors",
                         "the 2006 light's cone and its drops' amplitudes, from the real "
                         "database's factors");
  flags.preset = data_folder + "/presets/preview.toml";
  command->add_option("file", flags.factors, "factors, CSV")->required();
  command->add_option("--preset", flags.preset, "values to start from")->capture_default_str();
  command->add_option("--out", flags.out, "JSON to write")->required();
  command->footer(
      "example: pluvia fit factors data/factors/garg_nayar_2006_point_factors.csv --out fit.json");
  return command;
}

}  // namespace

CLI::App* add_fit(CLI::App& app, FitFlags& flags, const std::string& data_folder) {
  flags.outlines.data_folder = data_folder;
  CLI::App* fit = app.add_subcommand("fit", "fit unknowns to measured data, with Ceres");
  fit->require_subcommand(1);
  add_fit_outlines(*fit, flags.outlines);
  add_fit_streak(*fit, flags.streak, data_folder);
  add_fit_factors(*fit, flags.factors, data_folder);
  return fit;
}

std::string run_fit(const CLI::App& fit, const FitFlags& flags, const Progress& progress) {
  if (fit.got_subcommand("outlines")) return fit_outlines(flags.outlines);
  if (fit.got_subcommand("streak")) return fit_streak(flags.streak, progress);
  return fit_factors(flags.factors, progress);
}

}  // namespace pluvia
