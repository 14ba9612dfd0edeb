// The curves that `pluvia sweep` measures (validate/sweep.h). Each names in its text what its error
// is of; points come without front and recommendation.
#pragma once

#include <string>

#include "raytrace/generate.h"
#include "validate/sweep.h"

namespace pluvia {

struct SweepInputs {
  std::string preset_file = {};   // generator: of the kind gn2006
  std::string scene_file = {};    // renderer
  std::string atlas_folder = {};  // renderer
  int repeats = 3;                // of each time, >= 1
  bool quick = false;             // fewer settings, smaller pictures: to try it, not to quote it
};

// What a frame's rain costs by lookup, texels, streaks that stand for many, harmonics of the sky
// and drops that are left out, against the exact composite (validate/frame_composite.h) of all
// drops down to a lost_share of 0.01 in trilinear light. Three instants: the error is the mean of
// their relative RMSE of the rain, its standard error from their spread. Splashes, lens and shadows
// of the scene are left out: the composite has none. Times are of the passes that draw rain:
// processor time on a software rasteriser, wall-clock time on a GPU. Throws std::runtime_error for
// files, and as RainRenderer.
SweepCurve sweep_renderer(const SweepInputs& inputs, const Progress& progress);

}  // namespace pluvia
