// Single drops before a camera, each lit by three suns, and the light of each streak,
// from each sun by itself, in a picture or by the reference tracer. A sun stands at one height and
// azimuth for the whole scene; a channel of the picture is one sun, so one picture holds them all.
//
// A drop is put where the camera sees it from an exact view elevation, at the middle of the
// exposure; a sun of azimuth a for a drop straight before the camera has a + bearing for one to the
// right. So drops at bearings that are multiples of 20 degrees, and suns of the database's
// directions, are all lit by directions that the database holds.
//
// Light is what a streak adds to the dimmed background, S of realtime/rain_renderer.h, times area:
//   flux = sum over pixels of S [cd/m^2 px^2];   of the reference: sum (rain + coverage
//   background).
#pragma once

#include <array>
#include <vector>

#include "atlas/streak_atlas.h"
#include "raytrace/preset.h"
#include "raytrace/reference_picture.h"
#include "raytrace/scene.h"
#include "validate/metrics.h"
#include "validate/streak_flux.h"

namespace pluvia {

struct SeenDrop {
  double view_elevation_deg = 0;  // the camera looks down on the drop by so much
  double bearing_deg = 0;         // to the right of the camera's axis
  double distance_m = 5;          // of the middle of its path
  int oscillation = 0;
};

struct SunDirection {
  double elevation_deg = 0;
  double azimuth_deg = 0;  // for a drop at bearing 0: 0 the camera's side, 180 behind it
};

struct DropsScene {
  std::vector<SeenDrop> drops = {};
  std::array<SunDirection, 3> suns = {};          // each 100 lux in its own channel
  Eigen::Vector3d uniform_sky_cd_m2 = {0, 0, 0};  // instead of the suns where it is not black
};

// Of drops that fall as fast, as large and for as long as those of the atlas, seen by a camera at
// the origin that looks north and 20 degrees down, 256 x 256 px of 60 degrees.
Scene scene_of(const DropsScene& drops, const StreakAtlas& atlas);

// The rectangles that hold the streaks, 4 px wider than the streak's picture. Throws
// std::runtime_error where one leaves the picture or meets another.
std::vector<StreakMask> rectangles_of(const Scene& scene, const StreakAtlas& atlas);

// [drop][channel]
using DropLight = std::vector<std::array<double, 3>>;

struct ReferenceLight {
  DropLight light = {};
  DropLight standard_error = {};  // from the spread of the passes
  Image picture = {};             // S, RGB
  Image variance = {};            // of the rain
  int passes = 0;
};

// sets: of the atlas.
ReferenceLight reference_light(const Scene& scene, const Preset& preset,
                               const std::vector<int>& sets, const std::vector<StreakMask>& masks,
                               const ReferenceOptions& options, const ReferenceSettings& settings);

// picture: S, RGB.
DropLight light_in(const Image& picture, const std::vector<StreakMask>& masks);

// Drops and suns one after the other, as streaks, for flux_error.
std::vector<StreakFlux> fluxes_of(const DropLight& ours, const ReferenceLight& truth);

}  // namespace pluvia
