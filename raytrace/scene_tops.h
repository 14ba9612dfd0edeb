// The top heights (raytrace/top_height.h) of a scene's surfaces as they are posed
// (raytrace/moving_parts.h): the static and the dynamic top depth map of Creus (2010) in one grid.
// The grid is the same at all times, since it holds the whole paths of what moves. A step costs
// what the moving parts cover: the texels under them are kept, so that they can be taken away and
// laid down elsewhere. Grids on 5 cm, coarser where all directions of fall together would need more
// than 2^22 texels.
#pragma once

#include <vector>

#include "raytrace/scene.h"
#include "raytrace/top_height.h"

namespace pluvia {

TopHeight scene_top(const Scene& scene, const FallFrame& frame);

// From straight above, inside the rain's box alone.
TopHeight box_top(const Scene& scene);

// Takes the moving parts away.
void uncover_all(TopHeight& top);

// Lays the moving parts where scene.mesh has them now: the texels then are those of scene_top. A
// rectangle around all that may have changed, for each part; empty ones are left out.
std::vector<TexelRect> move_top(const Scene& scene, TopHeight& top);

}  // namespace pluvia
