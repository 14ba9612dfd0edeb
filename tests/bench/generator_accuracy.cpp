// What accuracy costs in the generator: shards of a preset traced with several settings, each
// against a much finer run of the field itself (generator_judge compares with brute force).
//
// Errors are relative to the finer run and hold its own error, too: that is printed as its
// estimate. It has another seed, so that its grids are turned otherwise.
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "raytrace/process_time.h"
#include "tests/bench/shard_choice.h"
#include "validate/light_errors.h"

namespace pluvia {
namespace {

struct AccuracyFlags {
  ShardFlags shards = {};
  std::string reference = {};
  std::vector<std::string> settings = {""};
};

// One setting, all shards.
struct Outcome {
  std::string setting = {};
  double used_s = 0;
  std::size_t nodes = 0;
  std::size_t dark = 0;  // pictures without light in the reference: no relative error
  std::vector<LightError> errors = {};
};

// Four times as fine in space, time, moments and bends.
StreakRequest four_times_finer(StreakRequest request) {
  request.slices *= 4;
  request.spans_per_period *= 2;
  request.field.base_cells *= 2;
  ++request.field.space_depth;
  ++request.field.time_depth;
  request.field.bend_tolerance /= 4;
  request.motion_tolerance /= 4;
  return request;
}

StreakRequest reference_of(const AccuracyFlags& flags, const StreakRequest& request) {
  StreakRequest reference = flags.reference.empty() ? four_times_finer(request) : request;
  ++reference.seed;
  apply_setting(flags.reference, reference);
  return reference;
}

TracedStreak timed_trace(const StreakRequest& request, Outcome& outcome) {
  const double start_s = process_cpu_s();
  TracedStreak streak = trace_streak(request);
  outcome.used_s += process_cpu_s() - start_s;
  outcome.nodes += streak.traced_nodes;
  return streak;
}

void add_errors(const ChosenShard& shard, const TracedStreak& streak, const TracedStreak& reference,
                Outcome& outcome) {
  for (std::size_t k = 0; k < streak.light.size(); ++k) {
    LightError error = light_error(streak.light[k], reference.light[k]);
    if (error.flux == 0) {
      ++outcome.dark;
      continue;
    }
    error.shard = shard.name;
    error.light = light_name(shard.request.lights[k]);
    outcome.errors.push_back(error);
  }
}

void print_outcome(const Outcome& outcome) {
  fmt::print("{:<40} {:8.2f} {:10}  {:<22} {:<22} {:<22} {:+.3f}{}\n", outcome.setting,
             outcome.used_s, outcome.nodes, spread(outcome.errors, &LightError::image),
             spread(outcome.errors, &LightError::flux_error),
             spread(outcome.errors, &LightError::estimate), 100 * total_flux_error(outcome.errors),
             outcome.dark > 0 ? fmt::format("  ({} dark lights left out)", outcome.dark) : "");
  std::fflush(stdout);
}

std::string csv_of(const std::vector<Outcome>& outcomes) {
  std::string text = "setting,shard,light,reference_flux_px,error,flux_error,estimate\n";
  for (const Outcome& outcome : outcomes) {
    for (const LightError& e : outcome.errors) {
      text += fmt::format("\"{}\",{},{},{},{},{},{}\n", outcome.setting, e.shard, e.light, e.flux,
                          e.image, e.flux_error, e.estimate);
    }
  }
  return text;
}

// The reference is compared with itself: what is left is its own estimate.
std::vector<Outcome> measure(const AccuracyFlags& flags) {
  std::vector<Outcome> outcomes(1);
  outcomes.front().setting =
      "reference: " + (flags.reference.empty() ? "4 times finer" : flags.reference);
  for (const std::string& setting : flags.settings) {
    outcomes.push_back({.setting = setting.empty() ? "preset" : setting});
  }
  for (const ChosenShard& shard : choose_shards(flags.shards)) {
    std::vector<StreakRequest> requests;  // all of them first: a wrong setting costs no time
    for (const std::string& setting : flags.settings) {
      requests.push_back(shard.request);
      apply_setting(setting, requests.back());
    }
    const TracedStreak reference =
        timed_trace(reference_of(flags, shard.request), outcomes.front());
    add_errors(shard, reference, reference, outcomes.front());
    for (std::size_t k = 0; k < requests.size(); ++k) {
      const TracedStreak streak = timed_trace(requests[k], outcomes[k + 1]);
      add_errors(shard, streak, reference, outcomes[k + 1]);
    }
  }
  return outcomes;
}

void judge(const AccuracyFlags& flags) {
  const std::vector<Outcome> outcomes = measure(flags);
  fmt::print("over lights and shards: median / 90th percentile / greatest, %\n");
  fmt::print("{:<40} {:>8} {:>10}  {:<22} {:<22} {:<22} {}\n", "setting", "CPU s", "nodes",
             "error of the picture", "of the flux", "own estimate", "total flux, %");
  for (const Outcome& outcome : outcomes) print_outcome(outcome);
  if (!flags.shards.csv.empty()) write_file_atomically(flags.shards.csv, csv_of(outcomes));
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("What accuracy costs: settings of the exit field against a finer run",
               "generator_accuracy");
  pluvia::AccuracyFlags flags;
  pluvia::add_shard_options(app, flags.shards);
  app.add_option("settings", flags.settings, "KEY=VALUE,.. of [accuracy]; \"\": the preset's own");
  app.add_option("--reference", flags.reference,
                 "KEY=VALUE,.. for the finer run; default: all four times finer");
  app.footer("example: generator_accuracy data/presets/preview.toml \"\" slices=512,space_depth=3");
  return pluvia::run_judge(app, flags.shards, argc, argv, [&] { pluvia::judge(flags); });
}
