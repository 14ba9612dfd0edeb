// A scene with a moving roof, for the tests of what moves.
#pragma once

#include <vector>

#include "raytrace/moving_parts.h"
#include "tests/realtime_fixture.h"

namespace pluvia {

// Level, its middle above the part's origin.
inline Mesh roof_of(float length_m, float width_m, float height_m) {
  Mesh roof;
  add_rectangle(roof, {-length_m / 2, -width_m / 2, height_m}, {length_m, 0, 0}, {0, width_m, 0},
                {.base_color = {0.6, 0.1, 0.1}});
  return roof;
}

// A roof of 3 x 2 m, 2.2 m high, that comes from the west along y = 4, is at x = 0 at 1 s and stops
// far in the east, over a ground of 60 x 60 m; 15,000 drops around the camera.
inline Scene shelter_scene() {
  Scene scene = rainy_scene(15000);
  add_moving_part(scene, roof_of(3, 2, 2.2f),
                  {{0, {-10, 4, 0}}, {1, {0, 4, 0}}, {2, {10, 4, 0}}, {2.5, {12, 4, 0}}});
  return scene;
}

// The same surfaces, none of which moves any more.
inline Scene standing_scene(Scene scene) {
  scene.moving.clear();
  return scene;
}

}  // namespace pluvia
