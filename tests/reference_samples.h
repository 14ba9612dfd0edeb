// Scenes for the tests of the reference tracer, made up in memory.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "raytrace/reference_picture.h"
#include "raytrace/reference_tracer.h"

namespace pluvia {

inline const Preset& gn2006_preset() {
  static const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/gn2006.toml");
  return preset;
}

// A camera that looks north from `at_m` with a focal length of 100 px, nothing else.
inline Scene dark_scene(int width_px = 16, int height_px = 16,
                        const Eigen::Vector3d& at_m = {0, 0, 0}) {
  Scene scene;
  scene.camera.position_m = at_m;
  scene.camera.target_m = at_m + Eigen::Vector3d(0, 1, 0);
  scene.camera.width_px = width_px;
  scene.camera.height_px = height_px;
  scene.camera.vertical_fov_deg = 2 * std::atan(height_px / 200.0) * 180 / std::numbers::pi;
  return scene;
}

// A drop of the list that starts there relative to the camera, never hits, and is set 0 (a sphere)
// or another of the ten.
inline Drop falling_drop(const Scene& scene, const Eigen::Vector3d& from_camera_m,
                         const Eigen::Vector3d& velocity_m_s = {0, 0, -8.49}, int oscillation = 0,
                         double r0_m = 1.6e-3) {
  return {.centre_m = scene.camera.position_m + from_camera_m,
          .velocity_m_s = velocity_m_s,
          .r0_m = r0_m,
          .oscillation = oscillation,
          .hit_time_s = 1e27};
}

inline std::unique_ptr<ReferenceScene> reference_scene(const Scene& scene, std::vector<Drop> drops,
                                                       const ReferenceOptions& options = {}) {
  for (std::size_t i = 0; i < drops.size(); ++i) drops[i].id = i;
  return make_reference_scene(scene, drops, gn2006_preset(), options);
}

// A square of side 2 half_m about a point, both triangles facing along `normal`.
inline Mesh square(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& normal, double half_m,
                   const Material& material) {
  const Eigen::Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  Mesh mesh;
  for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.positions_m.push_back((centre_m + half_m * (u * x + v * y)).cast<float>());
    mesh.normals.push_back(normal.cast<float>());
  }
  mesh.indices = {0, 1, 2, 0, 2, 3};
  mesh.materials = {material};
  mesh.triangle_material = {0, 0};
  return mesh;
}

struct Sampled {  // the mean of random values, and its standard error
  double sum = 0, squares = 0;
  long count = 0;
  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double mean() const { return sum / static_cast<double>(count); }
  double standard_error() const {
    const auto n = static_cast<double>(count);
    return std::sqrt(std::max(0.0, squares / n - mean() * mean()) / (n - 1));
  }
};

}  // namespace pluvia
