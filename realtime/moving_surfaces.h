// Before a frame of a scene with moving parts (raytrace/moving_parts.h): what hangs on where the
// surfaces are is brought to where they are now. Vertices, shadow maps, the rain's top heights, the
// splashes' heights: no shader, no buffer and no byte more than a scene has in which they stand
// still, and nothing that a frame made for this pose alone would have otherwise.
#pragma once

#include <string>

#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "realtime/rain_pass.h"
#include "realtime/scene_pass.h"
#include "realtime/shadow_pass.h"
#include "realtime/splash_pass.h"

namespace pluvia {

// rain, splashes: nullptr where the scene has none. Why there was nothing to do; empty: it was
// done.
std::string move_surfaces(Scene& scene, RainSpace& space, double time_s, const ScenePass& surfaces,
                          const ShadowPass& shadows, const RainPass* rain, SplashPass* splashes);

}  // namespace pluvia
