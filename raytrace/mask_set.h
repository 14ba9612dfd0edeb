// All masks that a renderer needs for the drops of a preset (atlas/refraction_masks.h), and `pluvia
// masks`, which traces them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "atlas/refraction_masks.h"
#include "raytrace/preset.h"

namespace pluvia {

struct MaskSetOptions {
  int size_px = 48;    // 4 .. 512
  int max_order = 2;   // 0 .. 15; what comes after them is the tail
  int phases = 9;      // masks of an oscillating drop, 1 .. 1024
  int instants = 128;  // its outlines, 1 .. 4096
  int angles = 64;     // of an outline, 16 .. 1024
  std::vector<int> view_elevations_deg = {-80, -60, -40, -20, 0, 20, 40, 60, 80};  // ascending
  std::vector<int> diameters_um = {};  // ascending; none: the preset's
};

struct MaskSetCost {
  double cpu_s = 0;
  double astray = 0;  // RefractionMask::astray, the greatest
};

// Of all of the preset's sets. Same bytes for any number of threads. progress: the share done.
// Throws std::invalid_argument for options out of range and a preset whose lights are points, and
// as drop_shape.
RefractionMasks trace_mask_set(const Preset& preset, const MaskSetOptions& options,
                               MaskSetCost& cost, const std::function<void(double)>& progress = {});

struct MasksFlags {
  std::string preset = {}, out = {};
  std::vector<double> diameters_mm = {};
  MaskSetOptions options = {};
};

CLI::App* add_masks(CLI::App& app, MasksFlags& flags);

// Writes them; returns a line about it.
std::string write_masks(const MasksFlags& flags,
                        const std::function<void(const std::string&, double)>& progress);

}  // namespace pluvia
