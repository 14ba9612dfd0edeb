// What the rain pass makes of a scene and an atlas before the first frame.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec4.hpp>

#include "atlas/streak_atlas.h"
#include "raytrace/scene.h"
#include "raytrace/top_height.h"
#include "realtime/rain_pass.h"

namespace pluvia {

// Throws std::runtime_error "scene: camera.exposure_s = 0.01 s; expected 0.0166667 s as in the
// atlas" and alike for fall speed, radius, options out of range, and an atlas without layers, views
// or lights.
void check_rain_inputs(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options);

// A streak has at least four columns, however thin it is: one that straddles two pixels in front of
// a bright lamp goes wrong else (relative RMSE of the street's rain against the exact composite
// 0.013 with four, 0.019 with two, 0.035 with one).
int coarsest_level(const StreakAtlas& atlas);

// The finest level that any streak of the scene can need: the nearest is as near as the rain's box,
// 0.1 m at least, in the picture's corner.
int finest_level_needed(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options);

RainUniforms rain_uniforms(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options, const TopHeight& top);

// Per layer, the layer of the mirrored drop.
std::vector<std::int32_t> mirrored_layers(const StreakAtlas& atlas);

std::vector<glm::vec4> atlas_light_directions(const StreakAtlas& atlas);  // unit, drop frame
std::vector<glm::vec4> atlas_views(const StreakAtlas& atlas);  // elevation in degrees, rows of path

}  // namespace pluvia
