// The viewer's window: frames, panel and keys until it is closed.
#pragma once

#include "realtime/viewer/viewer.h"
#include "realtime/viewer/window.h"

namespace pluvia {

struct ViewOptions {
  RenderOptions render = {};
  double start_s = 1;
  std::string out_folder = ".";  // of screenshots and paths
  int pixel_px = 1;              // of the window, along a side of the picture's pixel
  // Otherwise than 0: so many frames, 1 / frames_per_s apart, then a screenshot of the last one and
  // of the window (shot_NNNN_window.png), and done.
  int frames = 0;
  int frames_per_s = 24;
};

// Throws std::runtime_error when the scene is refused.
void view(Window& window, const Scene& scene, const StreakAtlas& atlas, const ViewOptions& options);

}  // namespace pluvia
