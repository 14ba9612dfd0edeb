// `pluvia fit`: unknowns from measured data (docs/fits.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "raytrace/generate.h"

namespace pluvia {

struct FitOutlinesFlags {
  std::string outlines = {}, out = {}, data_folder = {};
  std::vector<std::string> modes = {"20", "31"};
  std::optional<double> equilibrium_mm = {};
};

struct FitStreakFlags {
  std::string streaks = {}, preset = {}, out = {};
  std::vector<std::string> lights = {};
  int view_elevation_deg = 0;
  bool free_phases = false;
};

struct FitFactorsFlags {
  std::string factors = {}, preset = {}, out = {};
};

struct FitFlags {
  FitOutlinesFlags outlines = {};
  FitStreakFlags streak = {};
  FitFactorsFlags factors = {};
};

// data_folder: of the presets and tables that are taken unless flags name others.
CLI::App* add_fit(CLI::App& app, FitFlags& flags, const std::string& data_folder);

// Makes the fit that the parsed `fit` names and writes its file; returns lines about it. Throws
// after writing when the measurements are no drop's, and CLI::ValidationError for flags that do not
// go together.
std::string run_fit(const CLI::App& fit, const FitFlags& flags, const Progress& progress);

}  // namespace pluvia
