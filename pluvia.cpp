// pluvia: the one program. Each subcommand reads, calls one function of a folder, writes, and says
// what.

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <CLI/CLI.hpp>

#include "atlas/atomic_file.h"
#include "atlas/export_gn2006.h"
#include "atlas/flag_values.h"
#include "atlas/merge_databases.h"
#include "raytrace/generate_command.h"
#include "raytrace/import_database.h"
#include "raytrace/mask_set.h"
#include "raytrace/reference_command.h"
#include "realtime/compose_command.h"
#include "realtime/render_command.h"
#include "realtime/viewer/view_command.h"
#include "validate/compare_reports_command.h"
#include "validate/fidelity.h"
#include "validate/fit_command.h"
#include "validate/mattes_command.h"
#include "validate/sweep_command.h"
#include "validate/sweep_json.h"
#include "validate/sweep_page.h"

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A bar with the time left on a terminal; a plain line every ten seconds elsewhere.
struct ProgressLine {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const Clock::time_point start = Clock::now();
  Clock::time_point shown = start;

  void operator()(const std::string& what, double share) {
    if (share < 1 && seconds_since(shown) < (terminal ? 0.1 : 10)) return;
    shown = Clock::now();
    const double left_s = share > 0 ? seconds_since(start) * (1 - share) / share : 0;
    const std::string eta = share > 0.01 && share < 1 ? fmt::format(", {:.0f} s left", left_s) : "";
    if (terminal) {
      const auto full = static_cast<std::size_t>(30 * share);
      fmt::print(stderr, "\r\033[K[{:<30}] {:3.0f} % {}{}{}", std::string(full, '#'), 100 * share,
                 what, eta, share < 1 ? "" : "\n");
    } else {
      fmt::print(stderr, "{:3.0f} % {}{}\n", 100 * share, what, eta);
    }
    std::fflush(stderr);
  }
};

void generate(const pluvia::GenerateFlags& flags) {
  std::optional<tbb::global_control> limit;
  if (flags.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(flags.threads));
  }
  const pluvia::ChosenPreset chosen = pluvia::chosen_preset(flags);
  fmt::print("{}", chosen.left_out);
  const auto summary =
      pluvia::generate_database(chosen.preset, flags.out, ProgressLine(), flags.share);
  fmt::print("{}: {} shards traced in {:.1f} CPU s, {} found finished\n", flags.out, summary.traced,
             summary.cpu_s, summary.found);
}
struct PackFlags {
  std::string database = {}, out = {}, band = {};
  double diameter_mm = 0;
  bool orders_only = false;
};

void pack(const PackFlags& flags) {
  const auto diameter_um = static_cast<int>(std::lround(1000 * flags.diameter_mm));
  const pluvia::PackOptions options = {diameter_um, flags.band, !flags.orders_only};
  pluvia::write_atlas(flags.out, pluvia::pack_database(flags.database, options));
  fmt::print("{}: packed from {}\n", flags.out, flags.database);
}

struct MergeFlags {
  std::vector<std::string> databases = {};
  std::string out = {};
  bool partial = false;
};

void merge(const MergeFlags& flags) {
  const auto summary = pluvia::merge_databases(flags.databases, flags.out, flags.partial);
  fmt::print("{}: {} shards merged, {} missing\n", flags.out, summary.shards, summary.missing);
}

struct ExportFlags {
  std::string database = {}, out = {}, level = "transit", normalise = "shared", band = {};
  double diameter_mm = 0;
};

pluvia::StreakLevel level_of(const std::string& name) {
  return name == "transit" ? pluvia::StreakLevel::transit : pluvia::StreakLevel::exposure;
}

void export_layout(const ExportFlags& flags) {
  const auto normalise =
      flags.normalise == "shared" ? pluvia::Normalise::shared : pluvia::Normalise::each;
  const auto summary =
      pluvia::export_gn2006(flags.database, flags.out,
                            {.level = level_of(flags.level),
                             .normalise = normalise,
                             .diameter_um = static_cast<int>(std::lround(1000 * flags.diameter_mm)),
                             .band = flags.band});
  fmt::print("{}: {} pictures in the layout of 2006, {} shards left out\n", flags.out,
             summary.pictures, summary.shards_left_out);
}

struct ImportFlags {
  std::string layout = {}, out = {}, preset = {}, level = "transit";
};

void import_layout(const ImportFlags& flags) {
  const pluvia::Preset preset = pluvia::read_preset(flags.preset);
  const int shards = pluvia::import_gn2006(flags.layout, flags.out, preset, level_of(flags.level));
  fmt::print("{}: {} shards imported from {}\n", flags.out, shards, flags.layout);
}

void reference(const pluvia::ReferenceFlags& flags) {
  const auto summary = pluvia::reference_frame(flags, ProgressLine());
  fmt::print(
      "{}: {} drops, {} passes, {} new, relative error {:.3f} of the rain, {:.4f} without it, "
      "{:.1f} CPU s{}\n",
      flags.out, summary.drops, summary.passes, summary.new_passes, summary.errors.rain,
      summary.errors.surface, summary.cpu_s,
      summary.left_splashes ? "; splashes are left out" : "");
}

struct ValidateFlags {
  pluvia::FidelityInputs inputs = {};
  std::string out = {}, video = {}, sweep = {};
  bool quick = false, full = false;
};

// False when a check failed; the report is written all the same.
bool validate(const ValidateFlags& flags) {
  pluvia::make_folder(flags.out);  // before the minutes of measuring
  const pluvia::Sweep sweep =
      flags.sweep.empty() ? pluvia::Sweep() : pluvia::read_sweep(flags.sweep);
  pluvia::FidelityInputs inputs = flags.inputs;
  inputs.depth = flags.quick  ? pluvia::ReportDepth::quick
                 : flags.full ? pluvia::ReportDepth::full
                              : pluvia::ReportDepth::usual;
  pluvia::Report report = pluvia::measure_fidelity(inputs, ProgressLine());
  report.video = flags.video;
  pluvia::add_sweep(sweep, report);
  pluvia::write_report(flags.out, report);
  bool passed = true;
  for (const pluvia::Check& check : report.checks) {
    passed = passed && pluvia::passes(check);
    const bool headline = check.name == "sphere.energy.p2" ||
                          check.name == "gn2006.log_factor_rms.osc0" ||
                          check.name == "frame.composite";
    if (headline || !pluvia::passes(check)) {
      fmt::print("{:<4} {:<28} {:.5f} (at most {} {})\n", pluvia::passes(check) ? "ok" : "FAIL",
                 check.name, check.value, check.bound, check.unit);
    }
  }
  return passed;
}

// Prints what the reports say differently.
bool no_regression(const pluvia::CompareReportsFlags& flags) {
  const pluvia::ReportComparison comparison = pluvia::compare_reports(flags);
  fmt::print("{}", comparison.text);
  return !comparison.regression;
}

CLI::App* add_pack(CLI::App& app, PackFlags& flags) {
  CLI::App* command = app.add_subcommand("pack", "pack a database into the atlas a renderer reads");
  command->add_option("database", flags.database, "folder of the database")->required();
  command->add_option("--out", flags.out, "folder of the atlas")->required();
  command->add_option("--diameter-mm", flags.diameter_mm, "of the drops, where there are several")
      ->check(pluvia::finite_range(0.001, 20));
  command->add_option("--band", flags.band, "where there are several; R, G, B without: luminance");
  command->add_flag(
      "--orders-only", flags.orders_only,
      "no light beyond the orders that were traced; else what is left in a drop after "
      "them comes evenly from the sky");
  command->footer("example: pluvia pack db --out atlas");
  return command;
}

CLI::App* add_merge(CLI::App& app, MergeFlags& flags) {
  CLI::App* command = app.add_subcommand("merge", "make one database of those of several workers");
  command->add_option("databases", flags.databases, "folders of the databases")->required();
  command->add_option("--out", flags.out, "folder of the database, not there yet")->required();
  command->add_flag("--partial", flags.partial, "also when planned shards are missing");
  command->footer("example: pluvia merge db1 db2 db3 --out db");
  return command;
}

// For both directions of the layout.
void add_level(CLI::App& command, std::string& level) {
  command
      .add_option("--level", level, "brightness: while the drop is there, or mean of the exposure")
      ->check(CLI::IsMember({"transit", "exposure"}))
      ->capture_default_str();
}

CLI::App* add_export(CLI::App& app, ExportFlags& flags) {
  CLI::App* command = app.add_subcommand("export", "write a database in the layout of 2006");
  command->add_option("database", flags.database, "folder of the database")->required();
  command->add_option("--layout", "gn2006, the one known")
      ->required()
      ->check(CLI::IsMember({"gn2006"}));
  command->add_option("--out", flags.out, "folder of the pictures, not there yet")->required();
  add_level(*command, flags.level);
  command
      ->add_option("--normalise", flags.normalise,
                   "one factor for all sizes, or a maximum of 65535 in each picture")
      ->check(CLI::IsMember({"shared", "each"}))
      ->capture_default_str();
  command->add_option("--diameter-mm", flags.diameter_mm, "which of several sizes")
      ->check(pluvia::finite_range(0.001, 20));
  command->add_option("--band", flags.band, "which of several bands; luminance of R, G, B without");
  command->footer("example: pluvia export db --layout gn2006 --out rainstreakdb");
  return command;
}

CLI::App* add_import(CLI::App& app, ImportFlags& flags) {
  CLI::App* command = app.add_subcommand("import", "make a database of pictures in that layout");
  flags.preset = std::string(PLUVIA_DATA_DIR) + "/presets/gn2006.toml";
  command->add_option("layout", flags.layout, "folder of the pictures")->required();
  command->add_option("--out", flags.out, "folder of the database, not there yet")->required();
  command->add_option("--preset", flags.preset, "whose drops and fall the pictures show")
      ->capture_default_str();
  add_level(*command, flags.level);
  command->footer("example: pluvia import rainstreakdb --out db");
  return command;
}

CLI::App* add_validate(CLI::App& app, ValidateFlags& flags) {
  CLI::App* command = app.add_subcommand("validate", "measure fidelity and write the report");
  flags.inputs.data_folder = PLUVIA_DATA_DIR;
  flags.inputs.scene_files = {flags.inputs.data_folder + "/scenes/street.toml"};
  command->add_option("--database", flags.inputs.database_folder, "folder of the database")
      ->required();
  command->add_option("--atlas", flags.inputs.atlas_folder, "folder of its atlas")->required();
  command->add_option("--scene", flags.inputs.scene_files, "scenes of the checked frames")
      ->capture_default_str();
  CLI::Option* const quick = command->add_flag(
      "--quick", flags.quick, "without the long checks against brute force and the reference");
  command->add_option("--data", flags.inputs.data_folder, "the project's data folder")
      ->capture_default_str();
  command->add_option("--out", flags.out, "folder of report.json and index.html")->required();
  command
      ->add_flag("--full", flags.full,
                 "price every approximation: grids, sizes, skies, drawing; some 20 minutes")
      ->excludes(quick);
  command->add_option("--video", flags.video, "to show in the report, relative to its folder");
  command->add_option("--sweep", flags.sweep, "sweep.json of pluvia sweep, for its curves");
  command->footer("example: pluvia validate --database db --atlas atlas --out report");
  return command;
}

std::string command_line(int argc, char** argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) line += (i > 0 ? " " : "") + std::string(argv[i]);
  return line;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Pluvia: physically based rain streaks", "pluvia");
  app.require_subcommand(1);
  pluvia::GenerateFlags generate_flags;
  PackFlags pack_flags;
  MergeFlags merge_flags;
  ExportFlags export_flags;
  ImportFlags import_flags;
  pluvia::MasksFlags masks_flags;
  pluvia::RenderFlags render_flags;
  pluvia::ComposeFlags compose_flags;
  pluvia::ViewFlags view_flags;
  pluvia::ReferenceFlags reference_flags;
  ValidateFlags validate_flags;
  pluvia::FitFlags fit_flags;
  pluvia::SweepFlags sweep_flags;
  pluvia::MattesFlags mattes_flags;
  pluvia::CompareReportsFlags compare_reports_flags;
  CLI::App* const generate_command = pluvia::add_generate(app, generate_flags);
  CLI::App* const pack_command = add_pack(app, pack_flags);
  CLI::App* const merge_command = add_merge(app, merge_flags);
  CLI::App* const export_command = add_export(app, export_flags);
  CLI::App* const import_command = add_import(app, import_flags);
  CLI::App* const masks_command = pluvia::add_masks(app, masks_flags);
  CLI::App* const render_command = pluvia::add_render(app, render_flags);
  CLI::App* const compose_command = pluvia::add_compose(app, compose_flags);
  CLI::App* const view_command = pluvia::add_view(app, view_flags);
  CLI::App* const reference_command = add_reference(app, reference_flags, PLUVIA_DATA_DIR);
  CLI::App* const validate_command = add_validate(app, validate_flags);
  CLI::App* const fit_command = pluvia::add_fit(app, fit_flags, PLUVIA_DATA_DIR);
  CLI::App* const sweep_command = pluvia::add_sweep(app, sweep_flags, PLUVIA_DATA_DIR);
  CLI::App* const mattes_command = pluvia::add_mattes(app, mattes_flags);
  CLI::App* const compare_reports_command = pluvia::add_compare_reports(app, compare_reports_flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    const bool unknown = argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty();
    fmt::print(stderr, "pluvia: {}; see pluvia --help\n",
               unknown ? fmt::format("unknown subcommand \"{}\"", argv[1]) : error.what());
    return 2;
  }
  const std::string name = "pluvia " + app.get_subcommands().front()->get_name();
  try {
    if (*generate_command) generate(generate_flags);
    if (*pack_command) pack(pack_flags);
    if (*merge_command) merge(merge_flags);
    if (*export_command) export_layout(export_flags);
    if (*import_command) import_layout(import_flags);
    if (*masks_command) fmt::print("{}", pluvia::write_masks(masks_flags, ProgressLine()));
    if (*render_command) fmt::print("{}", pluvia::render_frames(render_flags, ProgressLine()));
    if (*compose_command) fmt::print("{}", pluvia::compose_frames(compose_flags, ProgressLine()));
    if (*view_command) pluvia::view_scene(view_flags);
    if (*reference_command) reference(reference_flags);
    if (*fit_command) fmt::print("{}", pluvia::run_fit(*fit_command, fit_flags, ProgressLine()));
    if (*mattes_command) fmt::print("{}", pluvia::find_mattes(mattes_flags, ProgressLine()));
    validate_flags.inputs.commands = {command_line(argc, argv)};
    if (*validate_command && !validate(validate_flags)) return 1;
    if (*sweep_command) {
      fmt::print("{}", pluvia::run_sweep(sweep_flags, command_line(argc, argv), ProgressLine()));
    }
    if (*compare_reports_command && !no_regression(compare_reports_flags)) return 1;
  } catch (const CLI::ParseError& error) {  // a value that only the input shows to be wrong
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 1;
  }
  return 0;
}
