// pluvia: the one program. Each subcommand reads, calls one function of a folder, writes, and says
// what.

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <CLI/CLI.hpp>

#include "atlas/atomic_file.h"
#include "atlas/export_gn2006.h"
#include "atlas/image_io.h"
#include "atlas/merge_databases.h"
#include "oscillation/equilibrium.h"
#include "raytrace/generate.h"
#include "raytrace/import_database.h"
#include "raytrace/reference_command.h"
#include "raytrace/scene_subset.h"
#include "realtime/rain_renderer.h"
#include "realtime/video.h"
#include "realtime/viewer/view.h"
#include "validate/compare_reports_command.h"
#include "validate/factor_fit.h"
#include "validate/fidelity.h"
#include "validate/fit_json.h"

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

struct GenerateFlags {
  std::string preset = {}, out = {}, scene = {};
  std::vector<int> views = {}, oscillations = {};
  std::vector<double> diameters_mm = {};
  std::optional<double> cone_half_angle_deg = {}, error = {};
  std::string isa = {};
  int threads = 0;
  pluvia::ShardShare share = {};
};

void refuse_missing_set(const pluvia::Preset& preset, int oscillation) {
  std::string known;
  for (const pluvia::OscillationSet& set : preset.sets) {
    if (set.index == oscillation) return;
    known += (known.empty() ? "" : ", ") + std::to_string(set.index);
  }
  throw CLI::ValidationError(
      "--oscillations", fmt::format("{}; expected one of the preset's {}", oscillation, known));
}

void choose_diameters(const std::vector<double>& diameters_mm, pluvia::Preset& preset) {
  const std::vector<int> known = pluvia::diameters_of(preset);
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

void refuse_views_below(const pluvia::Preset& preset) {
  for (const int view : preset.view_elevations_deg) {
    if (view >= 0 || preset.physical) continue;
    throw CLI::ValidationError("--views",
                               fmt::format("{}; expected 0 .. 80 for {}", view, preset.name));
  }
}

// Says what is left out, and what that saves.
pluvia::Preset choose_for_scene(const pluvia::Preset& preset, const std::string& file) {
  const auto subset = pluvia::scene_subset(preset, pluvia::read_scene(file), file);
  for (const pluvia::SubsetRow& row : subset.rows) {
    fmt::print("{:<12} kept     {}\n", row.what, row.kept.empty() ? "none" : row.kept);
    if (!row.left_out.empty()) fmt::print("{:<12} left out {}\n", "", row.left_out);
  }
  const auto share = [](long part, long all) {
    return 100 * (1 - static_cast<double>(part) / static_cast<double>(all));
  };
  fmt::print(
      "{} of {} shards, {} of {} images: saves {:.0f} % of the images and, at one time for "
      "each shard and band, {:.0f} % of the tracing\n",
      subset.shards, subset.all_shards, subset.images, subset.all_images,
      share(subset.images, subset.all_images), share(subset.tracings, subset.all_tracings));
  return subset.preset;
}

pluvia::Isa isa_from(const std::string& name) {
  try {
    return pluvia::isa_from_name(name);
  } catch (const std::runtime_error& error) {
    throw CLI::ValidationError("--isa", error.what());
  }
}

void generate(const GenerateFlags& flags) {
  std::optional<tbb::global_control> limit;
  if (flags.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(flags.threads));
  }
  pluvia::Preset preset = pluvia::read_preset(flags.preset);
  if (!flags.views.empty()) preset.view_elevations_deg = flags.views;
  if (!flags.oscillations.empty()) preset.oscillations = flags.oscillations;
  for (const int oscillation : preset.oscillations) refuse_missing_set(preset, oscillation);
  if (!flags.diameters_mm.empty()) choose_diameters(flags.diameters_mm, preset);
  refuse_views_below(preset);
  if (flags.cone_half_angle_deg) preset.cone_half_angle_deg = *flags.cone_half_angle_deg;
  if (flags.error) preset.target_error = *flags.error;
  if (!flags.isa.empty()) preset.field.isa = isa_from(flags.isa);
  if (!flags.scene.empty()) preset = choose_for_scene(preset, flags.scene);
  const auto summary = pluvia::generate_database(preset, flags.out, ProgressLine(), flags.share);
  fmt::print("{}: {} shards traced in {:.1f} CPU s, {} found finished\n", flags.out, summary.traced,
             summary.cpu_s, summary.found);
}

struct PackFlags {
  std::string database = {}, out = {}, band = {};
  double diameter_mm = 0;
};

void pack(const PackFlags& flags) {
  const auto diameter_um = static_cast<int>(std::lround(1000 * flags.diameter_mm));
  pluvia::write_atlas(flags.out, pluvia::pack_database(flags.database, {diameter_um, flags.band}));
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

struct QualityFlags {  // of a frame
  std::string lookup = "view-linear", packets = "automatic";
  int sky_degree = pluvia::RenderOptions{}.sky_degree;
  double far_streaks = pluvia::RenderOptions{}.far_streaks;
};

struct RenderFlags {
  std::string scene = {}, atlas = {}, out = {};
  int frames = 1;
  int frames_per_s = 24;
  double start_s = 1;
  bool plan = false;
  QualityFlags quality = {};
};

pluvia::RenderOptions render_options(const QualityFlags& flags) {
  using pluvia::LookupMode;
  using pluvia::PacketScheme;
  const std::map<std::string, LookupMode> lookups = {{"nearest", LookupMode::nearest},
                                                     {"view-linear", LookupMode::view_linear},
                                                     {"trilinear", LookupMode::trilinear}};
  const std::map<std::string, PacketScheme> schemes = {{"automatic", PacketScheme::automatic},
                                                       {"world", PacketScheme::world},
                                                       {"tree", PacketScheme::tree},
                                                       {"grid", PacketScheme::grid}};
  return {.far_streaks = flags.far_streaks,
          .packets = {.scheme = schemes.at(flags.packets)},
          .lookup = lookups.at(flags.lookup),
          .sky_degree = flags.sky_degree};
}

void render(const RenderFlags& flags) {
  const pluvia::Scene scene = pluvia::read_scene(flags.scene);
  pluvia::RainRenderer renderer(scene, pluvia::read_atlas(flags.atlas),
                                render_options(flags.quality));
  if (flags.plan) {
    fmt::print("{}", pluvia::plan_text(renderer.plan()));
    return;
  }
  if (flags.out.empty()) throw CLI::ValidationError("--out", "is required without --plan");
  pluvia::make_folder(flags.out);
  std::optional<pluvia::VideoWriter> video;
  // libx264 in its common format takes even sizes only.
  const bool even = scene.camera.width_px % 2 == 0 && scene.camera.height_px % 2 == 0;
  if (flags.frames > 1 && even && pluvia::ffmpeg_is_present()) {
    video.emplace(flags.out + "/rain.mp4", scene.camera.width_px, scene.camera.height_px,
                  flags.frames_per_s);
  }
  ProgressLine progress;
  std::vector<std::vector<pluvia::PassCost>> costs;
  for (int k = 0; k < flags.frames; ++k) {
    const pluvia::Frame frame =
        renderer.render(flags.start_s + static_cast<double>(k) / flags.frames_per_s);
    costs.push_back(frame.costs);
    const std::string name = fmt::format("{}/frame_{:04d}", flags.out, k);
    pluvia::write_exr(name + ".exr", frame.color);
    pluvia::write_png(name + ".png", frame.color, scene.camera.white_cd_m2);
    if (video) video->add(frame.color, scene.camera.white_cd_m2);
    progress(name, static_cast<double>(k + 1) / flags.frames);
  }
  if (video) video->finish();
  pluvia::write_file_atomically(flags.out + "/costs.json",
                                pluvia::costs_json(renderer.plan(), costs));
  std::string passes;
  for (std::size_t i = 0; i < costs.front().size(); ++i) {
    double seconds = 0;
    for (const auto& frame : costs) seconds += frame[i].wall_s / static_cast<double>(costs.size());
    passes += fmt::format(", {} {:.0f} ms", costs.front()[i].pass, 1e3 * seconds);
  }
  fmt::print("{}: {} frames{}{} a frame on {}\n", flags.out, flags.frames,
             video ? " and rain.mp4" : "", passes, renderer.gl_info().renderer);
  for (const pluvia::PlannedPass& pass : renderer.plan().passes) {
    for (const std::string& note : pass.notes)
      fmt::print("{}: {}: {}\n", flags.out, pass.name, note);
  }
}

struct ViewFlags {
  std::string scene = {}, atlas = {};
  int width_px = 1280, height_px = 720;
  QualityFlags quality = {};
  pluvia::ViewOptions options = {};
};

void view(const ViewFlags& flags) {
  const pluvia::Scene scene = pluvia::read_scene(flags.scene);
  // Before the seconds that an atlas takes to read.
  pluvia::Window window("Pluvia: " + flags.scene, {flags.width_px, flags.height_px});
  pluvia::ViewOptions options = flags.options;
  options.render = render_options(flags.quality);
  pluvia::view(window, scene, pluvia::read_atlas(flags.atlas), options);
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
  std::string out = {}, video = {};
};

// False when a check failed; the report is written all the same.
bool validate(const ValidateFlags& flags) {
  pluvia::make_folder(flags.out);  // before the minutes of measuring
  pluvia::Report report = pluvia::measure_fidelity(flags.inputs, ProgressLine());
  report.video = flags.video;
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

struct FitOutlinesFlags {
  std::string outlines = {}, out = {};
  std::vector<std::string> modes = {"20", "31"};
  std::optional<double> equilibrium_mm = {};
};

// "31" is n = 3, m = 1: degrees and orders of one digit.
pluvia::OutlineModel outline_model(const FitOutlinesFlags& flags) {
  pluvia::OutlineModel model;
  model.modes.clear();
  for (const std::string& mode : flags.modes) {
    if (std::count(flags.modes.begin(), flags.modes.end(), mode) > 1) {
      throw CLI::ValidationError("--modes", mode + " twice; expected each mode once");
    }
    model.modes.push_back({mode[0] - '0', mode[1] - '0'});
  }
  if (flags.equilibrium_mm) {
    const std::string table = std::string(PLUVIA_DATA_DIR) + "/tables/chuang_beard_1990_cn.csv";
    model.equilibrium_cos = pluvia::equilibrium_cos(pluvia::read_equilibrium_table(table),
                                                    1e-3 * *flags.equilibrium_mm);
  }
  return model;
}

// Throws after writing when the outlines are no drop's.
void fit_outlines(const FitOutlinesFlags& flags) {
  const pluvia::Outlines outlines = pluvia::read_outlines(flags.outlines);
  const pluvia::OutlineFit fit = pluvia::fit_outlines(outlines, outline_model(flags));
  pluvia::write_outline_fit(flags.out, outlines, fit);
  if (!fit.refusal.empty()) throw std::runtime_error(flags.outlines + ": " + fit.refusal);
  for (const pluvia::Estimate& estimate : fit.values) {
    fmt::print("{}\n", pluvia::estimate_line(estimate));
  }
  fmt::print("scatter {:.4g} mm, {} of {} points are outliers{}{}\n", fit.scatter_mm, fit.outliers,
             fit.points,
             fit.alternatives.empty()
                 ? ""
                 : fmt::format("; {} other drops fit as well", fit.alternatives.size()),
             fit.converged ? "" : "; not converged");
}

struct FitStreakFlags {
  std::string streaks = {}, preset = {}, out = {};
  std::vector<std::string> lights = {};
  int view_elevation_deg = 0;
  bool free_phases = false;
};

// The fits know the drops of 2006: spheres with two modes, one size, one band.
pluvia::Preset read_gn2006(const std::string& file) {
  pluvia::Preset preset = pluvia::read_preset(file);
  if (preset.name == "gn2006") return preset;
  throw CLI::ValidationError("--preset",
                             fmt::format("{}: {}; expected a preset of gn2006", file, preset.name));
}

// Throws after writing when the streaks are no drop's.
void fit_streak(const FitStreakFlags& flags) {
  pluvia::Preset preset = read_gn2006(flags.preset);
  const pluvia::StreakInput input =
      pluvia::read_streaks(flags.streaks, flags.lights, flags.view_elevation_deg);
  preset.width_px = input.width_px;
  pluvia::StreakRequest request = pluvia::shard_request(
      preset,
      {.oscillation = preset.sets.front().index, .view_elevation_deg = input.view_elevation_deg});
  request.environment.transfer_degree = -1;  // lights alone are fitted
  if (request.frame.height_px != input.height_px) {
    throw std::runtime_error(fmt::format("{}: {} x {} px; expected {} rows for that width and view",
                                         flags.streaks, input.width_px, input.height_px,
                                         request.frame.height_px));
  }
  ProgressLine progress;
  const pluvia::StreakFit fit =
      pluvia::fit_streak(request, input.streaks, pluvia::streak_starts(flags.free_phases),
                         {.free_phases = flags.free_phases, .known_level = input.known_level},
                         [&](double share) { progress("fit", share); });
  pluvia::write_streak_fit(flags.out, flags.streaks, input, fit);
  if (!fit.refusal.empty()) throw std::runtime_error(flags.streaks + ": " + fit.refusal);
  for (const pluvia::Estimate& estimate : fit.values) {
    fmt::print("{}\n", pluvia::estimate_line(estimate));
  }
  fmt::print("residual {:.1f} % of the pattern, {} streaks traced{}{}\n", 100 * fit.residual,
             fit.traced,
             fit.alternatives.empty()
                 ? ""
                 : fmt::format("; {} other drops fit as well", fit.alternatives.size()),
             fit.converged ? "" : "; not converged");
}

struct FitFactorsFlags {
  std::string factors = {}, preset = {}, out = {};
};

void print_sets(const pluvia::AmplitudeFit& fit) {
  for (const pluvia::SetAmplitudes& set : fit.sets) {
    fmt::print("set {}:", set.oscillation);
    for (const pluvia::Estimate& value : set.values) {
      fmt::print(" {};", pluvia::estimate_line(value));
    }
    fmt::print(" rms {:.3f} fitted, {:.3f} judged ({:.3f} with the preset's)\n", set.rms_fitted,
               set.rms_judged, set.rms_judged_preset);
  }
  fmt::print("{} streaks traced, their logarithms good to {:.4f}{}\n", fit.traced, fit.log10_noise,
             fit.converged ? "" : "; not converged");
}

void fit_factors(const FitFactorsFlags& flags) {
  const pluvia::Preset preset = read_gn2006(flags.preset);
  const auto factors = pluvia::read_real_factors(flags.factors);
  const pluvia::FactorFit fit = pluvia::fit_factors(preset, factors);
  ProgressLine progress;
  const pluvia::AmplitudeFit amplitudes =
      pluvia::fit_amplitudes(preset.sets, factors, pluvia::traced_model(preset, factors), {},
                             [&](double share) { progress("tables", share); });
  pluvia::write_factor_fit(flags.out, fit, amplitudes);
  const pluvia::FittedValue& cone = fit.cone;
  fmt::print("{} {} (from {})\n", cone.name,
             cone.identifiable ? fmt::format("{:.3f} +- {:.3f}", cone.value, cone.standard_error)
                               : "is not determined by these factors",
             cone.start);
  fmt::print("rms of log10(ours/theirs) {:.4f}, before {:.4f}{}\n", fit.rms_after, fit.rms_before,
             fit.converged ? "" : "; not converged");
  print_sets(amplitudes);
}

// CLI::Range lets nan pass: it is neither below the range nor above.
CLI::Validator finite_range(double low, double high) {
  const auto check = [low, high](const std::string& text) {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high)
      return std::string();
    return fmt::format("{}; expected {} .. {}", text, low, high);
  };
  return {check, fmt::format("FLOAT in [{} - {}]", low, high)};
}

// "i/n", 1 <= i <= n.
pluvia::ShardShare share_from(const std::string& text) {
  const std::size_t slash = text.find('/');
  pluvia::ShardShare share;
  const bool whole = slash != std::string::npos &&
                     text.find_first_not_of("0123456789/") == std::string::npos &&
                     CLI::detail::lexical_cast(text.substr(0, slash), share.index) &&
                     CLI::detail::lexical_cast(text.substr(slash + 1), share.count);
  if (whole && share.index >= 1 && share.index <= share.count) return share;
  throw CLI::ValidationError("--shard", fmt::format("{}; expected i/n with 1 <= i <= n", text));
}

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

CLI::App* add_pack(CLI::App& app, PackFlags& flags) {
  CLI::App* command = app.add_subcommand("pack", "pack a database into the atlas a renderer reads");
  command->add_option("database", flags.database, "folder of the database")->required();
  command->add_option("--out", flags.out, "folder of the atlas")->required();
  command->add_option("--diameter-mm", flags.diameter_mm, "of the drops, where there are several")
      ->check(finite_range(0.001, 20));
  command->add_option("--band", flags.band, "where there are several; R, G, B without: luminance");
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
      ->check(finite_range(0.001, 20));
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

void add_quality(CLI::App& command, QualityFlags& flags) {
  command.add_option("--lookup", flags.lookup, "cells that a streak mixes for a light: 1, 2 or 8")
      ->check(CLI::IsMember({"nearest", "view-linear", "trilinear"}))
      ->capture_default_str();
  command
      .add_option(
          "--sky-degree", flags.sky_degree,
          "spherical harmonics by which streaks see an environment map, as far as the atlas "
          "has them; 0: its mean from everywhere")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  command
      .add_option("--far-streaks", flags.far_streaks,
                  "streaks that cross a pixel within an e-fold of the distance; where there are "
                  "more, a few stand for all (1 .. 1e6); 0: every drop is drawn")
      ->check(CLI::IsMember({0}) | finite_range(1, 1e6))
      ->capture_default_str();
  command.add_option("--packets", flags.packets, "in which drops are selected; the same picture")
      ->check(CLI::IsMember({"automatic", "world", "tree", "grid"}))
      ->capture_default_str();
}

CLI::App* add_render(CLI::App& app, RenderFlags& flags) {
  CLI::App* command = app.add_subcommand("render", "render rain in a scene, in real time");
  command->add_option("scene", flags.scene, "scene, TOML")->required();
  command->add_option("--atlas", flags.atlas, "folder of the atlas")->required();
  command->add_option("--out", flags.out,
                      "folder of the frames: EXR, PNG, rain.mp4, costs.json (of each pass)");
  command->add_flag("--plan", flags.plan,
                    "only print the passes, shaders and bytes that the scene calls for");
  add_quality(*command, flags.quality);
  command->add_option("--frames", flags.frames, "number of frames")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option("--frames-per-s", flags.frames_per_s, "frame rate")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--start-s", flags.start_s, "time of the first frame")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command->footer("example: pluvia render data/scenes/street.toml --atlas atlas --out frames");
  return command;
}

CLI::App* add_view(CLI::App& app, ViewFlags& flags) {
  CLI::App* command = app.add_subcommand("view", "fly through rain in a scene, in a window");
  command->add_option("scene", flags.scene, "scene, TOML")->required();
  command->add_option("--atlas", flags.atlas, "folder of the atlas")->required();
  command->add_option("--out", flags.options.out_folder, "folder of screenshots and camera paths")
      ->capture_default_str();
  command->add_option("--width-px", flags.width_px, "of the window")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command->add_option("--height-px", flags.height_px, "of the window")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command
      ->add_option("--pixel-px", flags.options.pixel_px,
                   "of the window, along a side of the picture's pixel: more is faster")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  add_quality(*command, flags.quality);
  command->add_option("--start-s", flags.options.start_s, "time of the first frame")
      ->check(finite_range(0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--frames", flags.options.frames,
                   "draw so many, 1/24 s apart, leave pictures of the last and of the window in "
                   "--out, and close; 0: until the window is closed")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->footer("example: pluvia view data/scenes/street.toml --atlas atlas");
  return command;
}

CLI::App* add_validate(CLI::App& app, ValidateFlags& flags) {
  CLI::App* command = app.add_subcommand("validate", "measure fidelity and write the report");
  flags.inputs.data_folder = PLUVIA_DATA_DIR;
  flags.inputs.scene_file = flags.inputs.data_folder + "/scenes/street.toml";
  command->add_option("--database", flags.inputs.database_folder, "folder of the database")
      ->required();
  command->add_option("--atlas", flags.inputs.atlas_folder, "folder of its atlas")->required();
  command->add_option("--scene", flags.inputs.scene_file, "scene of the checked frame")
      ->capture_default_str();
  command->add_option("--data", flags.inputs.data_folder, "the project's data folder")
      ->capture_default_str();
  command->add_option("--out", flags.out, "folder of report.json and index.html")->required();
  command->add_option("--video", flags.video, "to show in the report, relative to its folder");
  command->footer("example: pluvia validate --database db --atlas atlas --out report");
  return command;
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
      pluvia::parse_light_name(text);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return {check, "light_vEE_hAAA"};
}

CLI::App* add_fit_streak(CLI::App& fit, FitStreakFlags& flags) {
  CLI::App* command = fit.add_subcommand("streak", "a drop's oscillation from its streaks");
  flags.preset = std::string(PLUVIA_DATA_DIR) + "/presets/preview.toml";
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

CLI::App* add_fit_factors(CLI::App& fit, FitFactorsFlags& flags) {
  CLI::App* command =
      fit.add_subcommand("factors",
                         "the 2006 light's cone and its drops' amplitudes, from the real "
                         "database's factors");
  flags.preset = std::string(PLUVIA_DATA_DIR) + "/presets/preview.toml";
  command->add_option("file", flags.factors, "factors, CSV")->required();
  command->add_option("--preset", flags.preset, "values to start from")->capture_default_str();
  command->add_option("--out", flags.out, "JSON to write")->required();
  command->footer(
      "example: pluvia fit factors data/factors/garg_nayar_2006_point_factors.csv --out fit.json");
  return command;
}

struct FitFlags {
  FitOutlinesFlags outlines = {};
  FitStreakFlags streak = {};
  FitFactorsFlags factors = {};
};

CLI::App* add_fit(CLI::App& app, FitFlags& flags) {
  CLI::App* fit = app.add_subcommand("fit", "fit unknowns to measured data, with Ceres");
  fit->require_subcommand(1);
  add_fit_outlines(*fit, flags.outlines);
  add_fit_streak(*fit, flags.streak);
  add_fit_factors(*fit, flags.factors);
  return fit;
}

void run_fit(const CLI::App& fit, const FitFlags& flags) {
  if (fit.got_subcommand("outlines")) fit_outlines(flags.outlines);
  if (fit.got_subcommand("streak")) fit_streak(flags.streak);
  if (fit.got_subcommand("factors")) fit_factors(flags.factors);
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
  GenerateFlags generate_flags;
  PackFlags pack_flags;
  MergeFlags merge_flags;
  ExportFlags export_flags;
  ImportFlags import_flags;
  RenderFlags render_flags;
  ViewFlags view_flags;
  pluvia::ReferenceFlags reference_flags;
  ValidateFlags validate_flags;
  FitFlags fit_flags;
  pluvia::CompareReportsFlags compare_reports_flags;
  CLI::App* const generate_command = add_generate(app, generate_flags);
  CLI::App* const pack_command = add_pack(app, pack_flags);
  CLI::App* const merge_command = add_merge(app, merge_flags);
  CLI::App* const export_command = add_export(app, export_flags);
  CLI::App* const import_command = add_import(app, import_flags);
  CLI::App* const render_command = add_render(app, render_flags);
  CLI::App* const view_command = add_view(app, view_flags);
  CLI::App* const reference_command = add_reference(app, reference_flags, PLUVIA_DATA_DIR);
  CLI::App* const validate_command = add_validate(app, validate_flags);
  CLI::App* const fit_command = add_fit(app, fit_flags);
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
    if (*render_command) render(render_flags);
    if (*view_command) view(view_flags);
    if (*reference_command) reference(reference_flags);
    if (*fit_command) run_fit(*fit_command, fit_flags);
    validate_flags.inputs.commands = {command_line(argc, argv)};
    if (*validate_command && !validate(validate_flags)) return 1;
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
