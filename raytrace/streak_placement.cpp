#include "raytrace/streak_placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "raytrace/light.h"

namespace pluvia {
namespace {

constexpr double least_path_rows = 0.01;
constexpr double degrees = 180 / std::numbers::pi;

// A point or a vector in the camera's axes: right, up, forward.
Eigen::Vector3d in_camera(const CameraFrame& frame, const Eigen::Vector3d& v) {
  return {v.dot(frame.right), v.dot(frame.up), v.dot(frame.forward)};
}

struct Projection {
  Eigen::Vector2d centre_px;
  double focal_px;
};

Eigen::Vector2d project(const Projection& view, const Eigen::Vector3d& p) {
  return view.centre_px + view.focal_px / p.z() * Eigen::Vector2d(p.x(), -p.y());
}

// How fast the projection of p moves when p moves by w.
Eigen::Vector2d derivative(const Projection& view, const Eigen::Vector3d& p,
                           const Eigen::Vector3d& w) {
  const Eigen::Vector2d moved(w.x() - p.x() / p.z() * w.z(), -(w.y() - p.y() / p.z() * w.z()));
  return view.focal_px / p.z() * moved;
}

struct DropFrame {  // x toward the camera, y image right, z against the fall
  Eigen::Vector3d x, y, z;
  double sin_view, cos_view;  // of the view elevation
};

DropFrame drop_frame(const CameraFrame& camera, const Eigen::Vector3d& velocity,
                     const Eigen::Vector3d& toward_camera) {
  DropFrame frame;
  frame.z = -velocity.normalized();
  const auto across = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return v - v.dot(frame.z) * frame.z;
  };
  Eigen::Vector3d x = across(toward_camera);
  frame.sin_view = toward_camera.dot(frame.z);
  frame.cos_view = x.norm();
  if (x.norm() < 1e-6) x = across(-camera.forward);
  if (x.norm() < 1e-6) x = across(camera.forward.dot(frame.z) > 0 ? camera.up : -camera.up);
  frame.x = x.normalized();
  frame.y = frame.z.cross(frame.x);
  return frame;
}

LitStreak lit_streak(const Illumination& lit, const DropFrame& frame) {
  const double x = lit.toward.dot(frame.x), y = lit.toward.dot(frame.y),
               z = lit.toward.dot(frame.z);
  return {.light_elevation_deg = std::atan2(z, std::hypot(x, y)) * degrees,
          .light_azimuth_deg = std::atan2(y, x) * degrees,
          .irradiance_lux = lit.lux};
}

}  // namespace

Eigen::Matrix3d drop_axes(const CameraFrame& camera, const Eigen::Vector3d& velocity,
                          const Eigen::Vector3d& toward_camera) {
  const DropFrame frame = drop_frame(camera, velocity, toward_camera);
  Eigen::Matrix3d axes;
  axes << frame.x, frame.y, frame.z;
  return axes;
}

SegmentTimes segment_times(double camera_exposure_s, double r0_m, const StreakGeometry& geometry) {
  if (geometry.any_exposure) return {1, camera_exposure_s};
  const double each_s = geometry.exposure_s * std::pow(r0_m / geometry.mean_radius_m, 1.5);
  // Both come from decimal text: a millionth more is no other segment.
  const double count = std::max(1.0, std::ceil(camera_exposure_s / each_s - 1e-6));
  if (count > most_segments) return {most_segments, camera_exposure_s / most_segments};
  return {static_cast<int>(count), each_s};
}

std::optional<StreakPlacement> place_streak(const Scene& scene, const Drop& drop,
                                            const StreakGeometry& geometry, int segment) {
  const SegmentTimes times = segment_times(scene.camera.exposure_s, drop.r0_m, geometry);
  const double start_s = segment * times.each_s;
  const double hit_time_s = drop.hit_time_s - start_s;
  const CameraFrame camera = camera_frame(scene.camera);
  const Projection view = {{scene.camera.width_px / 2.0, scene.camera.height_px / 2.0},
                           camera.focal_px};
  const Eigen::Vector3d path = drop.velocity_m_s * times.each_s;
  const Eigen::Vector3d start_m = drop.centre_m + drop.velocity_m_s * start_s;
  const Eigen::Vector3d middle = start_m + path / 2;
  const Eigen::Vector3d p0 = in_camera(camera, start_m - scene.camera.position_m);
  const Eigen::Vector3d p1 = p0 + in_camera(camera, path);
  const Eigen::Vector3d m = (p0 + p1) / 2;
  if (!(hit_time_s > 0) || p0.z() < nearest_depth_m || p1.z() < nearest_depth_m) return {};

  const Eigen::Vector3d toward_camera = (scene.camera.position_m - middle).normalized();
  const DropFrame frame = drop_frame(camera, drop.velocity_m_s, toward_camera);
  const Eigen::Vector3d up = frame.cos_view * frame.z - frame.sin_view * frame.x;
  const double pixel_m = geometry.pixel_m * drop.r0_m / geometry.mean_radius_m;
  const double top_row = geometry.path_top_row;
  StreakPlacement placed;
  placed.path_rows = std::max(path.norm() * frame.cos_view / pixel_m, least_path_rows);
  if (placed.path_rows >= 1)
    placed.row_px = (project(view, p1) - project(view, p0)) / placed.path_rows;
  else
    placed.row_px = derivative(view, m, in_camera(camera, -pixel_m * up));
  placed.column_px = derivative(view, m, in_camera(camera, pixel_m * frame.y));
  placed.origin_px =
      project(view, p0) - top_row * placed.row_px - geometry.cell_width_px / 2 * placed.column_px;
  placed.clip_row = std::numeric_limits<double>::infinity();
  const double left_s = scene.camera.exposure_s - start_s;
  const double end_s =
      left_s < times.each_s * (1 - 1e-6) ? std::min(left_s, hit_time_s) : hit_time_s;
  if (end_s < times.each_s) placed.clip_row = top_row + placed.path_rows * (end_s / times.each_s);
  placed.time_share = times.each_s / scene.camera.exposure_s;
  placed.depth_m = m.z();
  placed.distance_m = m.norm();
  placed.view_elevation_deg = std::atan2(frame.sin_view, frame.cos_view) * degrees;
  placed.world_from_drop << frame.x, frame.y, frame.z;
  for (const Light& light : scene.lights) {
    const Illumination lit = illumination(light, middle);
    if (inside_lamp(light, lit, drop.r0_m)) return {};
    placed.lights.push_back(lit_streak(lit, frame));
  }
  return placed;
}

double cell_row(double row, double path_top_row, double path_rows, double cell_path_rows) {
  if (row <= path_top_row) return row;
  if (row >= path_top_row + path_rows) return row - path_rows + cell_path_rows;
  return path_top_row + (row - path_top_row) / path_rows * cell_path_rows;
}

}  // namespace pluvia
