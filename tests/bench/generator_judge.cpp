// The exit field against brute force (brute_trial.h): errors of fixed lights, the bias of all
// lights' flux, and how much longer brute force takes to the same error. Its rays are followed by
// the same wide tracer as the field's, so that the times compare methods; --independent follows
// them by Embree and Mueller matrices.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/flag_values.h"
#include "tests/bench/brute_trial.h"

namespace pluvia {
namespace {

// Behind the drop, where refraction is smooth and bright; near the rainbows, whose caustics are
// sharp; to the side, where only reflections and grazing light are; from above and from below.
const std::vector<std::string> twelve_lights = {
    "light_v+10_h170", "light_v+10_h150", "light_v-30_h150", "light_v+30_h130",
    "light_v-10_h030", "light_v+30_h030", "light_v-50_h050", "light_v+10_h090",
    "light_v-10_h070", "light_v+70_h110", "light_v+90_h170", "light_v-90_h170"};

constexpr std::array<const char*, scales> scale_names = {"pixels", "rows"};

struct JudgeFlags {
  ShardFlags shards = {};
  std::string setting = {};
  TrialOptions trial = {.lights = twelve_lights};
  bool independent = false;
};

bool is_far(const SpeedRatio& ratio) {
  return ratio.extrapolation > farthest_extrapolation;
}

// In per cent; "<" where only a bound is known.
std::string error_text(const Figure& figure) {
  const BatchVerdict& verdict = figure.verdict;
  if (figure.ratio.speed == 0) return "dark";
  const double bound = std::max(verdict.square, 0.0) + 2 * verdict.standard_error;
  return figure.ratio.bound ? fmt::format("<{:.2f}", 100 * std::sqrt(bound))
                            : fmt::format("{:.2f}", 100 * std::sqrt(verdict.square));
}

// "!" where it rests on too far an extrapolation.
std::string speed_text(const SpeedRatio& ratio) {
  if (ratio.speed == 0) return "dark";
  return fmt::format("{}{:.3g}{}", ratio.bound ? ">" : "", ratio.speed, is_far(ratio) ? "!" : "");
}

// Per cent; 0 where brute force saw nothing.
std::string flux_text(const LightFlux& flux) {
  if (flux.brute.mean <= 0) return "dark";
  return fmt::format("{:+.3f} +- {:.3f}", 100 * (flux.field / flux.brute.mean - 1),
                     100 * flux.brute.standard_error / flux.brute.mean);
}

void print_trial(const Trial& trial, const std::vector<std::string>& lights) {
  fmt::print(
      "\n{}: field {:.2f} CPU s for all {} lights; brute force {:.1f} CPU s, {} batches, "
      "{:.3g} rays that met the drop; flux of all lights {} %\n",
      trial.shard, trial.field_s, trial.lights, trial.brute_s, trial.batches, trial.rays,
      flux_text(trial.total));
  fmt::print("{:<16} {:>10} {:>18} {:>8}", "", "flux, px", "field's flux, %", "one, s");
  for (const char* scale : scale_names) {
    fmt::print("  |{:>7}:{:>8} {:>8} {:>8} {:>8}", scale, "field, %", "brute, %", "all", "one");
  }
  fmt::print("\n");
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const Figure* figures = &trial.figures[4 * k];  // all: pixels, rows; one: pixels, rows
    fmt::print("{:<16} {:10.4g} {:>18} {:8.2f}", lights[k], trial.fluxes[k].brute.mean,
               flux_text(trial.fluxes[k]), figures[2].field_s);
    for (const Scale scale : {pixels, rows}) {
      fmt::print("  |{:>7} {:>8} {:8.2f} {:>8} {:>8}", "", error_text(figures[scale]),
                 100 * figures[scale].brute_error, speed_text(figures[scale].ratio),
                 speed_text(figures[2 + scale].ratio));
    }
    fmt::print("\n");
  }
  std::fflush(stdout);
}

void print_speeds(const std::vector<Trial>& trials, Scale scale, bool all) {
  std::vector<double> speeds;
  int bounds = 0, far = 0;
  for (const Trial& trial : trials) {
    for (const Figure& figure : trial.figures) {
      if (figure.all != all || figure.scale != scale || figure.ratio.speed == 0) continue;
      speeds.push_back(figure.ratio.speed);
      bounds += figure.ratio.bound ? 1 : 0;
      far += is_far(figure.ratio) ? 1 : 0;
    }
  }
  if (speeds.empty()) return;
  fmt::print("{:<6} {:<12} {:6}", scale_names[scale], all ? "all at once" : "one light",
             speeds.size());
  for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    fmt::print(" {:9.3g}", quantile(speeds, share));
  }
  fmt::print(" {:8} {:8}\n", bounds, far);
}

void print_law(const std::vector<Trial>& trials, Scale scale) {
  std::vector<double> exponents;
  for (const Trial& trial : trials) {
    exponents.insert(exponents.end(), trial.exponents[scale].begin(), trial.exponents[scale].end());
  }
  if (exponents.empty()) return;
  fmt::print(
      "brute force's error in {} goes as rays^{:.3f} (median; quartiles {:.3f}, {:.3f}); "
      "taken as rays^-0.5\n",
      scale_names[scale], quantile(exponents, 0.5), quantile(exponents, 0.25),
      quantile(exponents, 0.75));
}

// The lights' mean squared error is seen far better than any one light's. Errors of different
// lights are taken as independent: their rays leave in different directions.
void print_mean_error(const std::vector<Trial>& trials, Scale scale) {
  double square = 0, variance = 0, count = 0;
  for (const Trial& trial : trials) {
    for (const Figure& figure : trial.figures) {
      if (!figure.all || figure.scale != scale || figure.ratio.speed == 0) continue;
      square += figure.verdict.square;
      variance += figure.verdict.standard_error * figure.verdict.standard_error;
      ++count;
    }
  }
  if (count == 0) return;
  const double error = 2 * std::sqrt(variance);
  const auto root = [&](double x) { return 100 * std::sqrt(std::max(0.0, x / count)); };
  fmt::print("root mean square of the field's errors in {}: {:.2f} % ({:.2f} .. {:.2f}: 2 s.e.)\n",
             scale_names[scale], root(square), root(square - error), root(square + error));
}

void print_summary(const std::vector<Trial>& trials) {
  LightFlux total;
  double variance = 0;
  for (const Trial& trial : trials) {
    total.field += trial.total.field;
    total.brute.mean += trial.total.brute.mean;
    variance += trial.total.brute.standard_error * trial.total.brute.standard_error;
  }
  total.brute.standard_error = std::sqrt(variance);
  fmt::print("\nflux of all lights and shards together: {} %\n", flux_text(total));
  for (const Scale scale : {pixels, rows}) print_mean_error(trials, scale);
  for (const Scale scale : {pixels, rows}) print_law(trials, scale);
  fmt::print("\nCPU time of brute force to the field's error, over the field's CPU time\n");
  fmt::print("{:<19} {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8}\n", "", "count", "least",
             "10 %", "median", "90 %", "greatest", "bounds", "> 3x");
  for (const Scale scale : {pixels, rows}) {
    for (const bool all : {false, true}) print_speeds(trials, scale, all);
  }
}

std::string csv_of(const std::vector<Trial>& trials, const std::vector<std::string>& lights) {
  std::string text =
      "shard,light,scale,lights,square,square_error,brute_error,field_s,brute_s,ratio,"
      "extrapolation,bound\n";
  for (const Trial& trial : trials) {
    for (const Figure& f : trial.figures) {
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", trial.shard, lights[f.light],
                          scale_names[f.scale], f.all ? "all" : "one", f.verdict.square,
                          f.verdict.standard_error, f.brute_error, f.field_s, f.ratio.brute_s,
                          f.ratio.speed, f.ratio.extrapolation, f.ratio.bound ? 1 : 0);
    }
  }
  return text;
}

void judge(const JudgeFlags& flags) {
  std::vector<ChosenShard> shards = choose_shards(flags.shards);
  std::vector<Trial> trials;
  for (ChosenShard& shard : shards) {
    apply_setting(flags.setting, shard.request);
    trials.push_back(judge_shard(shard, flags.trial));
    print_trial(trials.back(), flags.trial.lights);
  }
  print_summary(trials);
  if (!flags.shards.csv.empty()) {
    write_file_atomically(flags.shards.csv, csv_of(trials, flags.trial.lights));
  }
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("The exit field against brute force", "generator_judge");
  pluvia::JudgeFlags flags;
  pluvia::TrialOptions& trial = flags.trial;
  pluvia::add_shard_options(app, flags.shards);
  app.add_option("--lights", trial.lights, "the judged ones")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--setting", flags.setting, "KEY=VALUE,.. of [accuracy] for the field");
  app.add_option("--batches", trial.batches, "of brute force, at least")
      ->check(CLI::Range(3, 10000))
      ->capture_default_str();
  app.add_option("--instants", trial.instants, "of half a batch")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  app.add_option("--rays-per-instant", trial.rays_per_instant, "over the drop's bounding square")
      ->check(CLI::Range(2, 100000000))
      ->capture_default_str();
  app.add_option("--brute-cpu-s", trial.brute_cpu_s, "of a shard's batches, at most")
      ->check(pluvia::finite_range(0, 1e9))
      ->capture_default_str();
  app.add_flag("--independent", flags.independent,
               "follow rays one by one with Embree and Mueller matrices, not as the field does");
  app.footer("example: generator_judge data/presets/preview.toml --width-px 8 --brute-cpu-s 60");
  return pluvia::run_judge(app, flags.shards, argc, argv, [&] {
    if (flags.independent) trial.follower = pluvia::RayFollower::independent;
    pluvia::judge(flags);
  });
}
