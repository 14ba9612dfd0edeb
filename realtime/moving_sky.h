// Before a frame of a scene whose environment is a clip of maps (atlas/environment_clip.h): what
// hangs on the sky is brought to the map of that time. The background, the light on surfaces, the
// fog's, the harmonics that streaks see, the mean that splashes do: no shader, no buffer and no
// byte more than a scene has under a map that stands still. A frame under a map does not hang on
// which was there before.
#pragma once

#include <memory>
#include <string>

#include "atlas/environment_clip.h"
#include "raytrace/scene.h"
#include "raytrace/sky_light.h"
#include "realtime/fog_pass.h"
#include "realtime/frame_plan.h"
#include "realtime/rain_pass.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct MovingSky {
  std::shared_ptr<EnvironmentClip> clip = {};  // nullptr: nothing changes
  int degree = 0;                              // of the harmonics that streaks see
  long shown = 0;                              // the map that is on the GPU
};

// The map to begin with is clip->at(shown): that of `kept`, which is of the same scene's
// environment (a video is then not read anew), or the first. Empty where the environment is no
// clip.
MovingSky make_moving_sky(const EnvironmentLight& environment, int degree, const MovingSky& kept);

// rain, fog: nullptr where the scene has none. Why there was nothing to do; empty: it was done.
std::string move_sky(MovingSky& sky, const EnvironmentLight& environment, double time_s,
                     ScenePass& surfaces, RainPass* rain, FogPass* fog);

PlannedPass plan_of(const MovingSky& sky, const EnvironmentLight& environment);

}  // namespace pluvia
