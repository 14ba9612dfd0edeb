// `pluvia mattes`: rain taken out of a clip (docs/mattes.md).
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "validate/rain_mattes.h"

namespace pluvia {

struct MattesFlags {
  std::string video = {}, out = {};
  int frames = 20;
  MatteSettings settings = {};
};

CLI::App* add_mattes(CLI::App& app, MattesFlags& flags);

// Writes the folder `out`, which must not be there yet, whole or not at all: background.exr and
// .png, mattes/NNNN.png by frame, strokes/NNNN.exr and .png, mattes.json; returns a line about it.
// Throws std::runtime_error as read_clip, rain_mattes and build_folder_atomically.
std::string find_mattes(const MattesFlags& flags,
                        const std::function<void(const std::string&, double)>& progress);

}  // namespace pluvia
