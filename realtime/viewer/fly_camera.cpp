#include "realtime/viewer/fly_camera.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

constexpr double nearest_m = 1e-3;  // to the camera's plane: what is nearer is not in the picture

Eigen::Vector3d turned(const Eigen::Vector3d& forward, const Eigen::Vector2d& turn_rad) {
  const double pitch = std::asin(std::clamp(forward.z(), -1.0, 1.0));
  const double low = std::min(pitch, -steepest_rad), high = std::max(pitch, steepest_rad);
  const double new_pitch = std::clamp(pitch + turn_rad.y(), low, high);
  const double bearing = std::atan2(forward.x(), forward.y()) + turn_rad.x();
  return {std::cos(new_pitch) * std::sin(bearing), std::cos(new_pitch) * std::cos(bearing),
          std::sin(new_pitch)};
}

}  // namespace

Camera fly(const Camera& camera, const FlyInput& input, double dt_s) {
  Camera next = camera;
  const CameraFrame frame = camera_frame(camera);
  if (!input.turn_rad.isZero(0)) {
    const double distance_m = (camera.target_m - camera.position_m).norm();
    next.target_m = camera.position_m + distance_m * turned(frame.forward, input.turn_rad);
  }
  if (!input.move.isZero(0)) {
    const Eigen::Vector3d way = input.move.x() * frame.right + input.move.y() * frame.forward +
                                input.move.z() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d step_m = input.speed_m_s * dt_s * way;
    next.position_m += step_m;
    next.target_m += step_m;
  }
  return next;
}

Camera resized(const Camera& camera, int width_px, int height_px) {
  Camera next = camera;
  next.width_px = width_px;
  next.height_px = height_px;
  return next;
}

std::optional<Eigen::Vector2d> seen_at_px(const Camera& camera, const Eigen::Vector3d& point_m) {
  const CameraFrame frame = camera_frame(camera);
  const Eigen::Vector3d c = point_m - camera.position_m;
  const double depth_m = c.dot(frame.forward);
  if (depth_m < nearest_m) return {};
  return Eigen::Vector2d(camera.width_px / 2.0 + frame.focal_px * c.dot(frame.right) / depth_m,
                         camera.height_px / 2.0 - frame.focal_px * c.dot(frame.up) / depth_m);
}

Eigen::Vector3d dragged_to(const Camera& camera, const Eigen::Vector3d& point_m,
                           const Eigen::Vector2d& to_px) {
  const CameraFrame frame = camera_frame(camera);
  const double depth_m = (point_m - camera.position_m).dot(frame.forward);
  return camera.position_m +
         depth_m *
             (frame.forward + (to_px.x() - camera.width_px / 2.0) / frame.focal_px * frame.right -
              (to_px.y() - camera.height_px / 2.0) / frame.focal_px * frame.up);
}

}  // namespace pluvia
