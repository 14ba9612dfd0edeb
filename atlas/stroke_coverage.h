// What streaks cover that take the shape of strokes (atlas/streak_strokes.h): as much as the
// atlas's drops, spread as the stroke's light is.
//
// Of a stroke S, in its pixels: x = a + b y, the straight line nearest to its light, is its middle;
// it goes from the first to the last row that has a tenth of the light of the brightest row; its
// width w_S is its light over the sum of its rows' largest values (validate/rain_strokes.h). Of G,
// what a drop covers in one view: the rows and columns where it is not 0, its middle u_G and its
// width w_G by the same rule. Then
//   B(u, r) = e S(a + b y + (u - u_G) w_S / w_G, y),   y from S's first to its last row as r goes
//                                                      from G's first to its last
// S linear between the middles of its pixels, 0 around it, averaged over a texel; e makes the sum
// of B that of G. So length, width and light of a streak are the drop's. Nothing covers more than
// all: where B would exceed `most`, all of the streak is brought nearer to the drop's,
//   C = (1 - l) B + l G,   l = 0 .. 1 the least for which C <= max(most, G)
// so that the sum is kept. Seen along its fall, where G is 1 already, a streak is the drop's.
#pragma once

#include "atlas/streak_atlas.h"

namespace pluvia {

// The layer that has the shape i of a set, where each oscillation set has so many.
constexpr int layer_of_shape(int set, int shapes_of_set, int i) {
  return set * shapes_of_set + i % shapes_of_set;
}

// How many layers each oscillation set needs so that every stroke is in one.
int shapes_of_set(const StreakAtlas& atlas);

// Coverage alone, of level 0: for each layer of the atlas shapes_of_set layers of its oscillation,
// the layer k of all with stroke k mod (number of strokes): some are there once more than others.
// most: > 0, of a texel. atlas.strokes is not empty. Throws std::runtime_error "FILE: .." for a
// stroke without light along its middle.
StreakAtlas stroke_coverage(const StreakAtlas& atlas, double most);

}  // namespace pluvia
