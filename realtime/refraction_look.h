// Model C as a look of streaks: Rousseau, Jolivet and Ghazanfarpour, "Realistic real-time rain
// rendering" (Computers and Graphics 30, 2006). A drop refracts the scene around the camera
// (realtime/capture_pass.h) by masks (raytrace/refraction_mask.h), pixel by pixel, and a pixel of
// its streak is the mean of N samples of it on its way through that pixel
// (realtime/shaders/rain_refraction.frag).
//
// Beyond what was published: masks hold reflection and the orders after straight refraction, are
// traced for each phase of the oscillation, and what they leave out shows the mean of the
// surroundings, so that no light is lost. Lamps without a surface are met exactly: each direction
// is compared with the direction to the lamp from where the drop is, as a disc of the database's
// cone. In the capture they would be seen from the camera instead, and in a texel or two.
//
// A streak thinner than RenderOptions::widest_splat_px has one radiance: lights by a sphere's
// transfer function, the scene by 24 lines of sight.
#pragma once

#include <string>
#include <vector>

#include "atlas/refraction_masks.h"
#include "atlas/streak_atlas.h"
#include "realtime/capture_pass.h"
#include "realtime/frame_plan.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_renderer.h"
#include "realtime/shader.h"

namespace pluvia {

constexpr int most_persistence_samples = 50;

struct RefractionLook {
  CapturePass capture = {};
  GlTexture masks = {};  // RGBA16F, one layer for each
  GlBuffer outlines = {}, sizes = {}, sets = {}, views = {}, reaches = {};
  ShaderDefines defines = {};  // of rain_refraction.glsl and rain_refraction.frag
  std::vector<std::string> notes = {};
};

// The distances of every drop seen from each side, the greatest of all times.
std::vector<float> outline_reaches(const RefractionMasks& masks);

// The index of the nearest diameter.
int nearest_diameter(const RefractionMasks& masks, double r0_m);

// Throws std::runtime_error where the atlas has no masks, options are out of range, the masks lack
// a set of the atlas, are more than this OpenGL holds, and for a scene with circles of a lens.
//
// Where a picture lasts longer than the exposure, `sizes` are made to have segments no longer than
// it: a streak's view and perspective are those of what is seen of its path.
RefractionLook make_refraction_look(const Scene& scene, const StreakAtlas& atlas,
                                    const RenderOptions& options, std::vector<GpuRainSize>& sizes);

void plan_refraction(const RefractionLook& look, PlannedPass& plan);

}  // namespace pluvia
