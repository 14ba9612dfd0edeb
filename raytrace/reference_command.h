// `pluvia reference`: a frame of a scene by the reference tracer.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "raytrace/generate.h"
#include "raytrace/reference_picture.h"

namespace pluvia {

struct ReferenceFlags {
  std::string scene = {}, preset = {}, out = {};
  int frame = 0;
  int frames_per_s = 24;
  double start_s = 1;
  double cone_half_angle_deg = 0;  // 0: the preset's
  int width_px = 0;                // 0: the scene's; the height follows
  int threads = 0;
  ReferenceOptions options = {};
  ReferenceSettings settings = {};
};

// data_folder: where the preset is looked for that --preset names when it is not given.
CLI::App* add_reference(CLI::App& app, ReferenceFlags& flags, const std::string& data_folder);

struct ReferenceSummary {
  std::size_t drops = 0;  // that were followed
  int passes = 0;         // that count
  int new_passes = 0;     // of them; the others were in FILE.sums
  ReferenceErrors errors = {};
  double cpu_s = 0;
  bool left_splashes = false;  // the scene asks for them, the reference has none
};

// Writes FILE (raytrace/reference_files.h) and FILE.sums, from which a later run goes on: after a
// kill, or to a smaller error. FILE is the same, to the byte, as of one unbroken run. Throws
// std::runtime_error for what the scene, the preset or FILE.sums has wrong.
ReferenceSummary reference_frame(const ReferenceFlags& flags, const Progress& progress = {});

}  // namespace pluvia
