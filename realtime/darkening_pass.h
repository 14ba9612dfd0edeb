// The scene's colours, paler and dimmer (Scene::darkening), before fog, blur and rain:
//   B' = brightness ((1 - desaturation) B + desaturation Y (1, 1, 1)),  Y the luminance of B.
// Made only for a scene with [darkening].
#pragma once

#include <string>

#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct DarkeningPass {
  Darkening values = {};
  ShaderProgram program = {};
};

DarkeningPass make_darkening_pass(const Darkening& darkening);

// Why there is nothing to do; empty: it was done, on the surfaces' colour.
std::string draw_darkening(const DarkeningPass& pass, const ScenePass& surfaces);

PlannedPass plan_of(const DarkeningPass& pass);

}  // namespace pluvia
