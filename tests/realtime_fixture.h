// Scenes for the tests of realtime/, and what they ask of the machine.
#pragma once

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "atlas/image.h"
#include "raytrace/scene.h"
#include "realtime/gl_context.h"

namespace pluvia {

// Why there is no OpenGL 4.5 on this machine; nothing where there is.
inline std::optional<std::string> missing_opengl() {
  try {
    const GlContext context;
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

#define PLUVIA_NEEDS_OPENGL() \
  if (const auto missing = missing_opengl()) GTEST_SKIP() << *missing

inline bool all_finite(const Image& image) {
  for (const float value : image.values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

inline void add_rectangle(Mesh& mesh, const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
                          const Eigen::Vector3f& b, const Material& material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  const Eigen::Vector3f normal = a.cross(b).normalized();
  for (const Eigen::Vector3f& p : {corner, Eigen::Vector3f(corner + a),
                                   Eigen::Vector3f(corner + a + b), Eigen::Vector3f(corner + b)}) {
    mesh.positions_m.push_back(p);
    mesh.normals.push_back(normal);
  }
  for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
  mesh.triangle_material.insert(mesh.triangle_material.end(), 2,
                                static_cast<std::uint32_t>(mesh.materials.size()));
  mesh.materials.push_back(material);
}

inline void add_ground(Mesh& mesh, float z_m) {
  add_rectangle(mesh, {-30, -30, z_m}, {60, 0, 0}, {0, 60, 0}, {.base_color = {0.2, 0.3, 0.4}});
}

// About so many drops around the camera, two lamps, a ground.
inline Scene rainy_scene(double drops) {
  Scene scene;
  scene.camera.width_px = 160;
  scene.camera.height_px = 120;
  scene.camera.position_m = {0.3, -0.4, 1.6};
  scene.camera.target_m = {1, 5, 2.1};
  scene.camera.exposure_s = 1.0 / 60;
  scene.lights = {{"left", {-3, 4, 5}, {900, 700, 400}}, {"right", {4, 7, 3}, {100, 300, 500}}};
  scene.environment.uniform_cd_m2 = {0.5, 0.6, 0.8};
  add_ground(scene.mesh, 0);
  scene.rain.box_min_m = {-6, -6, -0.5};
  scene.rain.box_max_m = {6, 12, 7};
  if (drops > 0) scene.rain.sizes = {{.drops_per_m3 = drops / (12 * 18 * 7.5)}};
  scene.rain.culling_radius_m = 20;  // all of the box
  scene.rain.local_height_m = 7.5;
  return scene;
}

}  // namespace pluvia
