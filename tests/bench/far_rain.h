// The scene of the rain benchmarks: drops in a box that the picture holds, in front of a faint sky.
// At scale 1 they are far, 12 to 40 m away.
#pragma once

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "raytrace/scene.h"

namespace pluvia {

inline Scene far_rain(double drops, int lights, double scale = 1) {
  Scene scene;
  scene.camera.width_px = 1280;
  scene.camera.height_px = 720;
  scene.camera.position_m = {0, 0, 8};
  scene.camera.target_m = {0, 10, 8};
  scene.camera.vertical_fov_deg = 50;
  scene.environment.uniform_cd_m2 = {0.5, 0.6, 0.8};
  scene.rain.box_min_m = {-9 * scale, 12 * scale, 8 - 5 * scale};
  scene.rain.box_max_m = {9 * scale, 40 * scale, 8 + 5 * scale};
  scene.rain.sizes = {{.drops_per_m3 = drops / (18 * 28 * 10 * scale * scale * scale)}};
  scene.rain.culling_radius_m = 45 * scale;
  scene.rain.local_height_m = 10 * scale;
  for (int i = 0; i < lights; ++i) {
    const double turn = 2 * std::numbers::pi * i / 6;
    scene.lights.push_back({fmt::format("lamp {}", i),
                            {9 * std::cos(turn), 26 + 15 * std::sin(turn), 9},
                            {900, 700, 400}});
  }
  return scene;
}

}  // namespace pluvia
