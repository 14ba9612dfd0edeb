#include "realtime/far_field.h"

#include <algorithm>
#include <cmath>

namespace pluvia {
namespace {

// Across the fall, from the camera to the nearest point of a cell.
double distance_m(const RainSizeSpace& size, const RainCell& cell,
                  const Eigen::Vector3d& camera_m) {
  const Eigen::Vector2d camera(camera_m.dot(size.frame.x), camera_m.dot(size.frame.y));
  const Eigen::Vector2d low = size.cell_m * Eigen::Vector2d(cell.x, cell.y);
  const Eigen::Vector2d high = low + Eigen::Vector2d::Constant(size.cell_m);
  return (camera.cwiseMax(low).cwiseMin(high) - camera).norm();
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
  const double crossing = density * size.drops.drops_per_m3 * length_m * across_m * across_m /
                          camera_frame(scene.camera).focal_px;
  if (!(crossing > far_streaks)) return {.drops = count};
  const double share = far_streaks / crossing;
  // One drop, at least, of a cell that has any.
  if (share * count < 1) return {.drops = 1, .counts_for = count};
  return {.drops = share * count, .counts_for = 1 / share};
}

}  // namespace pluvia
