#include "realtime/viewer/viewer.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/image_io.h"
#include "realtime/viewer/camera_recording.h"

namespace pluvia {
namespace {

// A slow frame moves the camera no farther than this much time does.
constexpr double longest_step_s = 0.2;

int picture_px(int window_px, int pixel_px) {
  return (window_px + pixel_px - 1) / pixel_px;
}

bool same_size(const Camera& a, const Camera& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px;
}

// The rain space is made for a look around from one place: so far from it, it is made anew.
bool has_flown_far(const Viewer& viewer) {
  const double radius_m = viewer.renderer->rain_space().culling_radius_m;
  return radius_m > 0 && (viewer.camera.position_m - viewer.made_at_m).norm() > radius_m / 2;
}

void make_renderer(Viewer& viewer) {
  Scene scene = edited_scene(viewer.scene, viewer.edits);
  scene.camera.position_m = viewer.camera.position_m;
  scene.camera.target_m = viewer.camera.target_m;
  scene.camera.width_px = viewer.camera.width_px;
  scene.camera.height_px = viewer.camera.height_px;
  scene.camera_path = look_around(scene.camera);
  if (viewer.renderer)
    viewer.renderer->remake(scene, *viewer.atlas, viewer.edits.options);
  else
    viewer.renderer =
        std::make_unique<RainRenderer>(viewer.context, scene, *viewer.atlas, viewer.edits.options);
  viewer.made = viewer.edits;
  viewer.made_at_m = viewer.camera.position_m;
}

// Keeps what can be drawn: an edit that is refused is undone.
void remake(Viewer& viewer) {
  if (!viewer.renderer) return make_renderer(viewer);
  try {
    make_renderer(viewer);
  } catch (const std::runtime_error& refusal) {
    viewer.message = refusal.what();
    viewer.edits = viewer.made;
    make_renderer(viewer);
  }
}

Camera edited_camera(const Viewer& viewer) {
  Camera camera = viewer.camera;
  camera.exposure_s = viewer.made.exposure_s;
  camera.vertical_fov_deg = viewer.made.vertical_fov_deg;
  camera.white_cd_m2 = viewer.edits.white_cd_m2;
  camera.depth_of_field = edited_lens(viewer.made);
  if (camera.depth_of_field) camera.depth_of_field->focus_m = viewer.edits.focus_m;
  return camera;
}

std::string free_name(const std::string& folder, const char* kind, const char* ending) {
  for (int i = 0;; ++i) {
    std::string name = fmt::format("{}/{}_{:04d}", folder, kind, i);
    if (!std::filesystem::exists(name + ending)) return name;
  }
}

}  // namespace

Viewer make_viewer(std::shared_ptr<GlContext> context, const Scene& scene, const StreakAtlas& atlas,
                   const RenderOptions& options, double time_s, const std::string& out_folder) {
  Viewer viewer;
  viewer.scene = scene;
  viewer.atlas = &atlas;
  viewer.out_folder = out_folder;
  viewer.edits = edits_of(scene, options);
  viewer.camera = camera_at(scene, time_s);
  if (viewer.camera.depth_of_field) viewer.edits.focus_m = viewer.camera.depth_of_field->focus_m;
  viewer.time_s = time_s;
  viewer.path = scene.camera_path;
  viewer.replaying = !viewer.path.empty();
  viewer.context = std::move(context);
  viewer.context->make_current();
  viewer.show = make_show_pass();
  return viewer;
}

bool draw_viewer(Viewer& viewer, bool settled, GLuint framebuffer, int width, int height) {
  if (width <= 0 || height <= 0) return false;
  viewer.context->make_current();
  const bool edited = settled && !needs_remake(viewer.made, viewer.edits).empty();
  const int pixel_px = settled || !viewer.renderer ? viewer.edits.pixel_px : viewer.made.pixel_px;
  const Camera before = viewer.camera;
  viewer.camera = resized(before, picture_px(width, pixel_px), picture_px(height, pixel_px));
  if (!viewer.renderer || edited || !same_size(before, viewer.camera) || has_flown_far(viewer))
    remake(viewer);
  viewer.camera = edited_camera(viewer);
  viewer.renderer->look_through(viewer.camera);
  viewer.renderer->set_lights(edited_lights(viewer.edits));
  viewer.renderer->set_wind(viewer.edits.wind);
  viewer.frame = viewer.renderer->draw(viewer.time_s);
  show_picture(viewer.show, viewer.renderer->picture(), viewer.edits.white_cd_m2, framebuffer,
               width, height);
  return true;
}

void advance(Viewer& viewer, const FlyInput& input, double dt_s, double time_s) {
  viewer.time_s = time_s;
  viewer.replaying = viewer.replaying && input.move.isZero(0) && input.turn_rad.isZero(0);
  if (viewer.replaying) {
    const Camera along = camera_at({.camera = viewer.camera, .camera_path = viewer.path}, time_s);
    viewer.camera.position_m = along.position_m;
    viewer.camera.target_m = along.target_m;
    if (along.depth_of_field) viewer.edits.focus_m = along.depth_of_field->focus_m;
    viewer.replaying = time_s < viewer.path.back().time_s;
  } else {
    viewer.camera = fly(viewer.camera, input, std::min(dt_s, longest_step_s));
  }
  if (viewer.recording) record_key(viewer.path, viewer.camera, time_s, recorded_every_s);
}

void start_recording(Viewer& viewer) {
  viewer.replaying = false;
  viewer.recording = true;
  viewer.path.clear();
  record_key(viewer.path, viewer.camera, viewer.time_s, recorded_every_s);
}

void stop_recording(Viewer& viewer) {
  viewer.recording = false;
  record_key(viewer.path, viewer.camera, viewer.time_s, least_key_s);
}

void start_replay(Viewer& viewer) {
  if (viewer.path.size() < 2) return;
  viewer.recording = false;
  viewer.replaying = true;
  viewer.time_s = viewer.path.front().time_s;
}

std::string save_screenshot(Viewer& viewer) {
  viewer.renderer->read(viewer.frame);
  make_folder(viewer.out_folder);
  const std::string name = free_name(viewer.out_folder, "shot", ".exr");
  write_exr(name + ".exr", viewer.frame.color);
  write_png(name + ".png", viewer.frame.color, viewer.camera.white_cd_m2);
  return name;
}

std::string save_path(const Viewer& viewer) {
  const std::string text = camera_path_toml(viewer.camera, viewer.path);
  make_folder(viewer.out_folder);
  const std::string name = free_name(viewer.out_folder, "path", ".toml");
  write_file_atomically(name + ".toml", text);
  return name;
}

}  // namespace pluvia
