// What a viewer knows, and its frames: a scene, its edits, a camera in flight, a clock, a
// recording. Needs an OpenGL context, but no window.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "realtime/rain_renderer.h"
#include "realtime/show_pass.h"
#include "realtime/viewer/fly_camera.h"
#include "realtime/viewer/scene_edits.h"

namespace pluvia {

struct Viewer {
  Scene scene = {};  // as read
  const StreakAtlas* atlas = nullptr;
  std::string out_folder = {};
  SceneEdits edits = {};
  Camera camera = {};                // as flown
  double time_s = 0;                 // of the rain
  double time_scale = 1;             // seconds of rain in a second; 0: it stands still
  std::vector<CameraKey> path = {};  // recorded; before that the scene's
  bool recording = false, replaying = false;
  std::string message = {};  // of the last file, or why an edit was refused

  // What was made of it:
  std::shared_ptr<GlContext> context = {};
  std::unique_ptr<RainRenderer> renderer = {};
  ShowPass show = {};
  SceneEdits made = {};
  Eigen::Vector3d made_at_m = {0, 0, 0};
  Frame frame = {};  // the last one: its costs and counts, no pictures
};

// The scene as read, from its camera or along its path. The atlas must outlive it.
Viewer make_viewer(std::shared_ptr<GlContext> context, const Scene& scene, const StreakAtlas& atlas,
                   const RenderOptions& options, double time_s, const std::string& out_folder);

// One frame at viewer.time_s into width x height px of the framebuffer (0: the window's). settled:
// whether edits that make the renderer anew may do so now, false while a slider is held. An edit
// that is refused is undone, and viewer.message says why. False for a window of no size: nothing is
// drawn. Throws std::runtime_error when the scene as read is refused.
bool draw_viewer(Viewer& viewer, bool settled, GLuint framebuffer, int width, int height);

// The camera dt_s later, as flown or, while replaying, along the path (any input ends that); the
// clock at time_s. While recording, a key every recorded_every_s of the clock.
constexpr double recorded_every_s = 0.5;
void advance(Viewer& viewer, const FlyInput& input, double dt_s, double time_s);

void start_recording(Viewer& viewer);
void stop_recording(Viewer& viewer);  // with a last key
void start_replay(Viewer& viewer);    // sets the clock to the path's first key

// The last frame as `pluvia render` writes it: out_folder/shot_NNNN.exr and .png, the first number
// that is free. Or the path, path_NNNN.toml (camera_recording.h). Returns the file's name without
// its ending. Throws std::runtime_error as their writers do.
std::string save_screenshot(Viewer& viewer);
std::string save_path(const Viewer& viewer);

}  // namespace pluvia
