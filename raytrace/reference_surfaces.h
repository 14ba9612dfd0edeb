// The surfaces of a scene for the reference tracer: its triangles in an Embree scene, relative to
// the camera, so that a scene far from the world's origin is as good as near it.
#pragma once

#include <memory>
#include <optional>

#include "raytrace/reference_drops.h"
#include "raytrace/scene.h"

namespace pluvia {

struct MetSurface {
  double distance_m = 0;
  Eigen::Vector3d position_m = {0, 0, 0};  // from the camera
  Eigen::Vector3d normal = {0, 0, 1};      // unit; of the vertices, linear between them
  Eigen::Vector3d facet = {0, 0, 1};       // unit; of the triangle, against the ray
  Material material = {};
};

class SurfaceGeometry {
 public:
  // Throws std::runtime_error when Embree cannot start.
  SurfaceGeometry(const Mesh& mesh, const Eigen::Vector3d& camera_m);
  ~SurfaceGeometry();
  SurfaceGeometry(const SurfaceGeometry&) = delete;
  SurfaceGeometry& operator=(const SurfaceGeometry&) = delete;

  // The first surface before far_m. Thread-safe, as is the other.
  std::optional<MetSurface> nearest(const Ray& ray, double far_m) const;
  bool is_blocked(const Ray& ray, double far_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Where a ray to a light may start so that its own triangle, in float, is not in the way: above the
// facet by 1e-5 of the distance from the camera (float errs by 1e-7 of it), on the light's side.
Eigen::Vector3d above_surface(const MetSurface& point, const Eigen::Vector3d& toward);

}  // namespace pluvia
