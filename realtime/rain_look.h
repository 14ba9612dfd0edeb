// How light gets into a streak that is not traced (RenderOptions::look): model B of Wang, Lin,
// Fang, Wei and Guo, "Real-Time Rendering of Realistic Rain" (MSR-TR-2006-102), a sphere with a
// transfer function, and a flat white streak. The streak is where and as wide as the traced one:
//
//   sphere     coverage (sum over lights E D(angle) + sum_lm c_lm k_l Y_lm(from the eye on))
//   published  the same C with averaged reflectance and one ray for each angle, and C + c B for
//   it,
//              B the background behind the streak
//   white      coverage x one radiance
//
// (realtime/shaders/rain_look.glsl, raytrace/sphere_transfer.h; E [lux], D [1/sr], c_lm those of
// raytrace/sky_light.h, to degree 3.) a (C + c B) + (1 - a) B is a C + (1 - (1 - c) a) B: light of
// all of its coverage, and a background that is hidden by 1 - c of it. So it is drawn, and streaks
// behind it count as its background.
//
// Of the atlas a look needs the coverage alone. A streak that takes the shape of a stroke
// (StreakAtlas::strokes) has the light and the coverage of the one that it stands for, elsewhere.
#pragma once

#include <string>
#include <vector>

#include "atlas/streak_atlas.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "raytrace/sky_light.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/rain_renderer.h"
#include "realtime/shader.h"

namespace pluvia {

// Half a degree, as wide as the sun: what is finer no light of the scene shows.
constexpr int transfer_rings = 360;
constexpr int look_sky_degree = 3;                  // as published: 16 coefficients
constexpr double published_background_share = 0.7;  // c

struct RainLook {
  StreakLook look = StreakLook::traced;
  double background_share = 0;       // c
  double streak_cd_m2 = 0;           // of the white one
  double brightest_per_lux = 0;      // greatest value of D
  int sky_cells = 0;                 // harmonics of the sky that streaks see
  GlBuffer transfer = {}, sky = {};  // where a light, or a sky, is there

  bool traced() const { return look == StreakLook::traced; }
};

// Throws std::runtime_error for options out of range, or that the look does not heed, and for
// billboards, which are traced.
void check_look(const RenderOptions& options);

// sky: as streaks of this look see it.
RainLook make_rain_look(const Scene& scene, const RenderOptions& options, const SkyLight& sky);

// Another sky of as many harmonics.
void set_sky(const RainLook& look, const SkyLight& sky);

// The same places, views and layers without light; of an atlas with strokes, the layers of
// atlas/stroke_coverage.h, so that no streak of the space's sizes covers more than all.
StreakAtlas coverage_alone(const StreakAtlas& atlas, const RainSpace& space, double exposure_s);

// Whether streaks of the look may take the shape of strokes.
bool takes_strokes(StreakLook look);

// What the plan should say.
std::vector<std::string> look_notes(const RainLook& look, const StreakStrokes& strokes);

// Of rain_look.glsl and of those that include it.
ShaderDefines look_defines(const RainLook& look);

}  // namespace pluvia
