// What the judges of the generator share: which shards of a preset they trace, with which settings,
// and what time it takes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "raytrace/preset.h"

namespace pluvia {

struct ShardFlags {
  std::string preset = {};
  std::vector<int> oscillations = {1, 3, 8}, views = {0, 40};
  std::vector<double> diameters_mm = {};  // empty: the preset's first
  std::optional<double> cone_half_angle_deg = {};
  std::optional<int> width_px = {};
  int threads = 1;  // more add the waiting of idle ones to the CPU time
  std::string csv = {};
};

void add_shard_options(CLI::App& app, ShardFlags& flags);

struct ChosenShard {
  std::string name = {};
  StreakRequest request = {};
};

// The first band of every combination. Throws std::runtime_error for a bad preset, CLI::ParseError
// for an oscillation, diameter or view that it does not have.
std::vector<ChosenShard> choose_shards(const ShardFlags& flags);

// "KEY=VALUE,.." in their order: the keys of a preset's table [accuracy], "seed", and "level", all
// of them at once (raytrace/streak_accuracy.h). Empty: no change. Throws CLI::ValidationError.
void apply_setting(const std::string& setting, StreakRequest& request);

// The body of a judge's main: limits the threads, prints errors as pluvia does, and returns its
// exit codes: 0 done, 1 input failed, 2 wrong use.
int run_judge(CLI::App& app, const ShardFlags& flags, int argc, char** argv,
              const std::function<void()>& judge);

}  // namespace pluvia
