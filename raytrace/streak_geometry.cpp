#include "raytrace/streak_geometry.h"

namespace pluvia {

StreakGeometry streak_geometry(const StreakAtlas& atlas) {
  return {.pixel_m = atlas.pixel_m,
          .cell_width_px = static_cast<double>(atlas.cell_width_px),
          .exposure_s = atlas.exposure_s,
          .path_top_row = atlas.views.at(0).path_top_row,
          .mean_radius_m = atlas.mean_radius_m,
          .any_exposure = !atlas.strokes.empty()};
}

}  // namespace pluvia
