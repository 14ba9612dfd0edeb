// `pluvia view`: its flags, and the window.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "realtime/render_command.h"
#include "realtime/viewer/view.h"

namespace pluvia {

struct ViewFlags {
  std::string scene = {}, atlas = {};
  int width_px = 1280, height_px = 720;
  QualityFlags quality = {};
  ViewOptions options = {};
};

CLI::App* add_view(CLI::App& app, ViewFlags& flags);

// Until the window is closed, or --frames are drawn. Throws as view.
void view_scene(const ViewFlags& flags);

}  // namespace pluvia
