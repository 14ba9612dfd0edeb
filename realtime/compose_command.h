// `pluvia compose`: rain over a photograph or a video, with its layers (docs/compose.md).
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "realtime/render_command.h"

namespace pluvia {

struct ComposeFlags {
  std::string scene = {}, image = {}, video = {}, depth = {}, atlas = {}, out = {};
  double depth_scale_m = 0;              // metres of 1 in a PNG of depths; 0: not given
  std::optional<double> one_cd_m2 = {};  // radiance of 1; nothing: white for whole numbers, else 1
  double mask_coverage = 0.01;
  std::optional<int> frames = {};  // nothing: 1 of a picture, all of a video
  int frames_per_s = 24;
  double start_s = 1;
  bool plan = false;
  QualityFlags quality = {};
};

CLI::App* add_compose(CLI::App& app, ComposeFlags& flags);

// Writes the folder `out`, which must not be there yet, whole or not at all, or nothing of it with
// --plan; returns lines about that. progress: what was written, and the share of the whole. Throws
// std::runtime_error as RainRenderer, and for files; CLI::ValidationError for flags that do not go
// together.
std::string compose_frames(const ComposeFlags& flags,
                           const std::function<void(const std::string&, double)>& progress);

}  // namespace pluvia
