#include "raytrace/rain_fog.h"

#include <algorithm>
#include <cmath>

#include "raytrace/ray_stretch.h"

namespace pluvia {
namespace {

// Where the ray leaves the prism.
double local_end(const RainFog& fog, const FogSlab& slab, const Eigen::Vector3d& direction) {
  const double along = direction.dot(slab.against_fall);
  const double across = (direction - along * slab.against_fall).norm();
  RayStretch local;
  clip(0, along, slab.low_m, slab.high_m, local);
  if (across > 0) local.to = std::min(local.to, fog.culling_radius_m / across);
  return std::max(0.0, local.to);
}

}  // namespace

double air_per_m(const Scene& scene) {
  if (!scene.fog) return 0;
  return scene.fog->extinction_per_m + mean_density(scene.rain.density) * scene.rain.undrawn_per_m;
}

RainFog rain_fog(const Scene& scene, const RainSpace& space) {
  RainFog fog;
  if (!scene.fog) return fog;
  const Eigen::Vector3d& camera_m = scene.camera.position_m;
  fog.everywhere_per_m = air_per_m(scene);
  fog.culling_radius_m = space.culling_radius_m;
  fog.box_min_m = scene.rain.box_min_m - camera_m;
  fog.box_max_m = scene.rain.box_max_m - camera_m;
  for (std::size_t i = 0; i < scene.rain.sizes.size(); ++i) {
    const RainSizeSpace& size = space.sizes[i];
    const double per_m = mean_density(scene.rain.density) * extinction_per_m(size.drops);
    const auto same = std::find_if(fog.slabs.begin(), fog.slabs.end(), [&](const FogSlab& slab) {
      return same_fall({.z = slab.against_fall}, size.frame);
    });
    if (same != fog.slabs.end()) {
      same->per_m += per_m;
      continue;
    }
    const double floor_m =
        local_space(space, static_cast<int>(i), camera_m, 0).floor_m - camera_m.dot(size.frame.z);
    fog.slabs.push_back({size.frame.z, per_m, floor_m, floor_m + space.local_height_m});
  }
  return fog;
}

double fog_depth(const RainFog& fog, const Eigen::Vector3d& direction, double distance_m) {
  double depth = fog.everywhere_per_m > 0 ? fog.everywhere_per_m * distance_m : 0;
  RayStretch box;
  for (int axis = 0; axis < 3; ++axis)
    clip(0, direction[axis], fog.box_min_m[axis], fog.box_max_m[axis], box);
  box.to = std::min(box.to, distance_m);
  for (const FogSlab& slab : fog.slabs) {
    const double from = std::max(box.from, local_end(fog, slab, direction));
    if (box.to > from) depth += slab.per_m * (box.to - from);
  }
  return depth;
}

}  // namespace pluvia
