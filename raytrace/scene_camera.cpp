// The camera of raytrace/scene.h.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "raytrace/key_path.h"
#include "raytrace/scene.h"

namespace pluvia {
namespace {

double focus_at(const std::vector<CameraKey>& keys, double time_s) {
  const std::size_t i = key_before(keys, time_s);
  const bool between = time_s >= keys.front().time_s && i + 1 < keys.size();
  const CameraKey& next = between ? keys[i + 1] : keys[i];
  const double u = between ? (time_s - keys[i].time_s) / (next.time_s - keys[i].time_s) : 0;
  return 1 / ((1 - u) / keys[i].focus_m + u / next.focus_m);
}

}  // namespace

CameraFrame camera_frame(const Camera& camera) {
  const Eigen::Vector3d forward = (camera.target_m - camera.position_m).normalized();
  const bool vertical = std::hypot(forward.x(), forward.y()) < 1e-6;
  const Eigen::Vector3d hint =
      vertical ? Eigen::Vector3d(0, forward.z() < 0 ? 1 : -1, 0) : Eigen::Vector3d(0, 0, 1);
  CameraFrame frame;
  frame.forward = forward;
  frame.right = forward.cross(hint).normalized();
  frame.up = frame.right.cross(forward);
  const double half_fov = camera.vertical_fov_deg * std::numbers::pi / 360;
  frame.focal_px = camera.height_px / (2 * std::tan(half_fov));
  return frame;
}

Camera camera_at(const Scene& scene, double time_s) {
  Camera camera = scene.camera;
  const std::vector<CameraKey>& keys = scene.camera_path;
  if (keys.empty()) return camera;
  camera.position_m = along_path(keys, time_s, &CameraKey::position_m);
  camera.target_m = along_path(keys, time_s, &CameraKey::target_m);
  if (camera.depth_of_field) camera.depth_of_field->focus_m = focus_at(keys, time_s);
  const Eigen::Vector3d ahead = camera.target_m - camera.position_m;
  if (ahead.norm() < 1e-3) {
    const std::size_t i = key_before(keys, time_s);
    const Eigen::Vector3d way = keys[i].target_m - keys[i].position_m;
    camera.target_m = camera.position_m + 1e-3 * way.normalized();
  }
  return camera;
}

long clip_picture(const EnvironmentLight& environment, double time_s) {
  if (environment.frames_per_s == 0) return 0;
  const double place = (time_s - environment.start_s) * environment.frames_per_s;
  return static_cast<long>(std::max(0.0, std::floor(place + 1e-6)));
}

std::vector<Camera> camera_samples(const Scene& scene, int count) {
  if (scene.camera_path.empty()) return {scene.camera};
  const double first_s = scene.camera_path.front().time_s;
  const double last_s = scene.camera_path.back().time_s;
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i)
    cameras.push_back(camera_at(scene, first_s + (last_s - first_s) * i / std::max(1, count - 1)));
  return cameras;
}

}  // namespace pluvia
