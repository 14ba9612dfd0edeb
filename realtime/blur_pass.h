// The scene out of focus as a whole (Scene::blur), after fog, before rain: a Gaussian of the means
// of pixels, along rows and then along columns,
//   B'_x = sum_i w_i B_(x + i) / sum_i w_i,  w_i = exp(-i^2 / (2 sigma^2)),  |i| <= ceil(3 sigma),
// pixels beyond the border like those at it. Depth is not looked at. Wang et al. (MSR-TR-2006-102)
// soften a rainy scene so. Made only for a scene with [blur].
#pragma once

#include <string>

#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct BlurPass {
  double sigma_px = 0;
  GlBuffer weights = {};  // w_i / sum, i = 0 .. reach
  GlTexture across = {};  // blurred along rows
  ShaderProgram rows = {}, columns = {};
};

BlurPass make_blur_pass(const Blur& blur, const ScenePass& surfaces);

// Why there is nothing to do; empty: it was done, on the surfaces' colour.
std::string draw_blur(const BlurPass& pass, const ScenePass& surfaces);

PlannedPass plan_of(const BlurPass& pass);

}  // namespace pluvia
