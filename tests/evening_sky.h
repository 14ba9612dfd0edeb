// A sky of several colours and an atlas whose streaks see it by its spherical harmonics.
#pragma once

#include <cmath>

#include "atlas/image_io.h"
#include "raytrace/environment_map.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {

// The quarter atlas with harmonics to degree 3.
inline const StreakAtlas& sky_atlas() {
  static const StreakAtlas atlas = [] {
    StreakAtlas made =
        synthetic_atlas({.cell_width_px = 8, .levels = 4, .path_rows = 247, .margin_rows = 4});
    add_harmonics(made, 3);
    return made;
  }();
  return atlas;
}

// Bright and bluish above, with a glow low in one direction; dark below.
inline Image evening_map() {
  Image map = make_image(64, 32, 3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Eigen::Vector3d d = map_direction(map, x + 0.5, y + 0.5);
      const double sky = d.z() > 0 ? 0.5 + d.z() : 0.1;
      const double glow = 3 * std::exp(-4 * (d - Eigen::Vector3d(0.8, 0.5, 0.1)).squaredNorm());
      map.at(x, y, 0) = static_cast<float>(0.8 * sky + glow);
      map.at(x, y, 1) = static_cast<float>(0.9 * sky + 0.6 * glow);
      map.at(x, y, 2) = static_cast<float>(1.2 * sky + 0.2 * glow);
    }
  }
  return map;
}

// rainy_scene under that map, its rain of two sizes slanted by two winds.
inline Scene evening_scene(const TemporaryFolder& folder, double drops) {
  Scene scene = rainy_scene(drops);
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 2};
  write_exr(scene.environment.map_file, evening_map());
  scene.rain.sizes = {scene.rain.sizes[0], scene.rain.sizes[0]};
  scene.rain.sizes[0].velocity_m_s = {2, -1, -8};
  scene.rain.sizes[1].velocity_m_s = {-1.5, 0.5, -4};
  scene.rain.sizes[1].r0_m = 0.8e-3;
  return scene;
}

}  // namespace pluvia
