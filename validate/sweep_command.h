// `pluvia sweep`: measures cost-accuracy curves, and picks settings from measured ones.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "validate/sweep_curves.h"

namespace pluvia {

struct SweepFlags {
  SweepInputs inputs = {};
  std::vector<std::string> curves = {};  // empty: all of them
  std::string out = {}, from = {};
  std::optional<double> budget_s = {}, error = {};
};

// data_folder: the project's, for the preset and the scene that are taken unless told otherwise.
CLI::App* add_sweep(CLI::App& app, SweepFlags& flags, const std::string& data_folder);

// Measures the curves and writes OUT/sweep.json (validate/sweep_json.h), OUT/NAME.svg of each and
// OUT/index.html, or reads them from `from`; returns lines: what a time or an error picks from each
// front, or all points. A curve whose inputs are not given is told under `skipped`, unless it is
// named. Throws std::runtime_error for files and where nothing can be picked, CLI::ValidationError
// for flags that do not go together.
std::string run_sweep(const SweepFlags& flags, const std::string& command,
                      const Progress& progress);

}  // namespace pluvia
