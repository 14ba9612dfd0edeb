// What a frame of rain should be: the streak pictures of the same drops, at full resolution,
// integrated exactly over every screen pixel in double, put over the scene drop by drop from back
// to front. With the renderer it shares the drops (raytrace/drop_field.h), their places on screen
// (raytrace/streak_placement.h) and the choice of cells (atlas/atlas_lookup.h), and nothing else:
// no mip, no profile, no accumulation in integers, no approximation of many streaks over each
// other.
#pragma once

#include <vector>

#include "atlas/atlas_lookup.h"
#include "atlas/image.h"
#include "atlas/streak_atlas.h"
#include "raytrace/drop_field.h"
#include "raytrace/scene.h"
#include "raytrace/sky_light.h"
#include "validate/streak_flux.h"

namespace pluvia {

// What lights the scene's streaks from all around: its uniform environment, or its map to that
// degree, as far as the atlas has harmonics; the map's mean where it has none.
SkyLight sky_of(const Scene& scene, const StreakAtlas& atlas, int most_degree);

struct FrameComposite {
  Image color = {};  // RGB, cd/m^2
  Image rain = {};   // RGB: color - background, rounded once (the rain-only signal of a comparison)
  long drops_seen = 0;                   // that touch at least one pixel in front of the scene
  std::vector<StreakMask> streaks = {};  // those pixels, of each of them, the farthest first
};

// For each drop, from the farthest to the nearest (depth_m of its placement; equal: lower id
// first), in every pixel where it is nearer than the scene's depth: B <- (1 - c) B + S with
//   c = integral of coverage, S = max(0, integral of (sum_lights E_l S_l + sum_sky c_k S_k))
// over the pixel: S_k is the picture under uniform light for a sky of degree 0, else that of each
// harmonic, the sky turned into the frame of each streak.
// Every texel of level 0 is a parallelogram on screen (cut where the row stretch of cell_row
// changes and at clip_row) over which its flux, value x |column x row| px^2, lies evenly; its share
// in a pixel is the area of the polygon inside it. Both neighbouring views are laid down with their
// weights. Fog dims S on its way to the camera; what it does to the background is there already.
//
// drops: as drop_field gives them. sky: in the world. background: RGB, depth_m:
// one channel (+infinity where there is no surface), both of the camera's size. The result does not
// depend on the number of threads. Throws std::runtime_error for pictures of another size, values
// that are not finite, for a light that casts shadows, and an oscillation set that the atlas does
// not hold.
FrameComposite composite_frame(const Scene& scene, const StreakAtlas& atlas,
                               const std::vector<Drop>& drops, const SkyLight& sky,
                               const Image& background, const Image& depth_m,
                               LookupMode mode = LookupMode::view_linear);

}  // namespace pluvia
