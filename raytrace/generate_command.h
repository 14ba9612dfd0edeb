// `pluvia generate`: its flags, and the preset that they ask for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "raytrace/generate.h"

namespace pluvia {

struct GenerateFlags {
  std::string preset = {}, out = {}, scene = {};
  std::vector<int> views = {}, oscillations = {};
  std::vector<double> diameters_mm = {};
  std::optional<double> cone_half_angle_deg = {}, error = {};
  std::string isa = {};
  int threads = 0;
  ShardShare share = {};
};

CLI::App* add_generate(CLI::App& app, GenerateFlags& flags);

struct ChosenPreset {
  Preset preset = {};
  std::string left_out = {};  // lines about what --for leaves out, and what that saves
};

// Throws CLI::ValidationError for what the preset does not have, std::runtime_error for files.
ChosenPreset chosen_preset(const GenerateFlags& flags);

}  // namespace pluvia
