// `pluvia render`: its flags, those of a frame's quality, and frames to files.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "realtime/rain_renderer.h"

namespace pluvia {

struct QualityFlags {  // of a frame
  std::string lookup = "view-linear", look = "traced", packets = "automatic";
  std::optional<double> background_share = {}, streak_cd_m2 = {};
  std::string strokes = {};                  // of streaks that take their shapes
  std::string masks = {}, capture = "cube";  // of streaks that refract
  int persistence_samples = RenderOptions{}.persistence_samples;
  int capture_px = RenderOptions{}.capture_px;
  int sky_degree = RenderOptions{}.sky_degree;
  double far_streaks = RenderOptions{}.far_streaks;
};

struct RenderFlags {
  std::string scene = {}, atlas = {}, out = {};
  int frames = 1;
  int frames_per_s = 24;
  double start_s = 1;
  bool plan = false;
  QualityFlags quality = {};
};

void add_quality(CLI::App& command, QualityFlags& flags);
RenderOptions render_options(const QualityFlags& flags);

// With the masks or strokes that the flags name, if any.
StreakAtlas read_atlas(const std::string& folder, const QualityFlags& flags);

CLI::App* add_render(CLI::App& app, RenderFlags& flags);

// Writes the frames, their video and costs.json, or none of it with --plan; returns lines about
// that. progress: what was written, and the share of the whole. Throws std::runtime_error as
// RainRenderer, and for files; CLI::ValidationError for flags that do not go together.
std::string render_frames(const RenderFlags& flags,
                          const std::function<void(const std::string&, double)>& progress);

}  // namespace pluvia
