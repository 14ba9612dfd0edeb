#include "realtime/far_field.h"

#include <algorithm>
#include <cmath>

namespace pluvia {
namespace {

// Across the fall, from a place to the nearest point of a cell.
double distance_m(const RainSizeSpace& size, const RainCell& cell, const Eigen::Vector3d& place_m) {
  const Eigen::Vector2d place(place_m.dot(size.frame.x), place_m.dot(size.frame.y));
  const Eigen::Vector2d low = size.cell_m * Eigen::Vector2d(cell.x, cell.y);
  const Eigen::Vector2d high = low + Eigen::Vector2d::Constant(size.cell_m);
  return (place.cwiseMax(low).cwiseMin(high) - place).norm();
}

// Over which the light of the drops beyond across_m stays alike.
double stretch_m(const Scene& scene, const RainSizeSpace& size, const RainCell& cell,
                 double across_m) {
  double stretch_m = across_m;
  for (const Light& light : scene.lights) {
    if (light.kind != LightKind::sun)
      stretch_m = std::min(stretch_m, 2 * distance_m(size, cell, light.position_m));
  }
  return stretch_m;
}

}  // namespace

KeptDrops kept_drops(const Scene& scene, const RainSpace& space, const SizedCell& cell,
                     double far_streaks) {
  const RainSizeSpace& size = space.sizes[static_cast<std::size_t>(cell.size)];
  const auto count = static_cast<double>(cell.cell.count);
  if (far_streaks == 0 || cell.cell.count == 0) return {.drops = count};
  const int x = cell.cell.x, y = cell.cell.y;
  const double density = rain_share(scene.rain, size, {x, y, x + 1, y + 1});
  const double length_m = size.speed_m_s * scene.camera.exposure_s;
  const double across_m = distance_m(size, cell.cell, scene.camera.position_m);
  const double crossing = density * size.drops.drops_per_m3 * length_m * across_m *
                          stretch_m(scene, size, cell.cell, across_m) /
                          camera_frame(scene.camera).focal_px;
  if (!(crossing > far_streaks)) return {.drops = count};
  const double share = far_streaks / crossing;
  // One drop, at least, of a cell that has any.
  if (share * count < 1) return {.drops = 1, .counts_for = count};
  return {.drops = share * count, .counts_for = 1 / share};
}

}  // namespace pluvia
