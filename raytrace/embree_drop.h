// Drops as Embree geometry: the analytic surface as a user geometry whose double-precision rays
// travel beside Embree's float ones, and a triangle mesh with smooth normals as the independent
// second way.
#pragma once

#include <memory>
#include <optional>

#include "raytrace/drop_intersect.h"

namespace pluvia {

// The analytic drop in an Embree scene of its own. Built once for a bounding radius; any instant
// whose surface lies within it can be asked for without a rebuild. Thread-safe after construction.
class EmbreeDrop {
 public:
  // Throws std::runtime_error when Embree cannot start.
  explicit EmbreeDrop(double bounding_radius_m);
  ~EmbreeDrop();
  EmbreeDrop(const EmbreeDrop&) = delete;
  EmbreeDrop& operator=(const EmbreeDrop&) = delete;

  std::optional<DropHit> intersect(const DropInstant& drop, const Eigen::Vector3d& origin_m,
                                   const Eigen::Vector3d& direction, RaySide side) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The drop at one instant as a subdivided octahedron: 8 * 4^levels triangles, corners exactly on
// the surface, corner normals exact, both interpolated linearly.
class MeshDrop {
 public:
  MeshDrop(const DropInstant& drop, int levels);
  ~MeshDrop();
  MeshDrop(const MeshDrop&) = delete;
  MeshDrop& operator=(const MeshDrop&) = delete;

  std::size_t triangle_count() const;

  // A ray that starts on the surface must start a little off it (1e-6 of the radius) on its own
  // side.
  std::optional<DropHit> intersect(const Eigen::Vector3d& origin_m,
                                   const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pluvia
