// The scene around the camera, drawn once a frame for drops that refract
// (realtime/refraction_look.h): a cube map, or, as published, one flat picture of 165 degrees about
// the camera's axis. Surfaces and the environment as the camera sees them, without fog and rain,
// and over them a picture that is given (realtime/picture_pass.h) where its camera looks; lamps are
// not in it, unless as surfaces. Linear radiance in cd/m^2, with all mip levels.
//
// All drops share it. What is at distance D is seen from a drop at distance d from the camera in a
// direction that differs by up to d / D radians.
#pragma once

#include <vector>

#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/picture_pass.h"
#include "realtime/rain_renderer.h"
#include "realtime/scene_pass.h"
#include "realtime/shadow_pass.h"

namespace pluvia {

// tan 82.5 degrees: of half the published field of view, of a drop's straight refraction.
constexpr double wide_tangent = 7.595754112725151;

struct CapturePass {
  SceneCapture kind = SceneCapture::cube;
  int size_px = 0;  // of each side
  GlTexture picture = {};
  GlTexture depth = {};
  std::vector<GlFramebuffer> faces = {};
};

// Mip levels of the picture.
int capture_levels(const CapturePass& pass);

CapturePass make_capture_pass(SceneCapture kind, int size_px);

// For the camera that `surfaces` has now. picture: nullptr, or one that is refracted.
void draw_capture(const CapturePass& pass, const ScenePass& surfaces, const ShadowPass& shadows,
                  const PicturePass* picture);

PlannedPass plan_of(const CapturePass& pass);

}  // namespace pluvia
