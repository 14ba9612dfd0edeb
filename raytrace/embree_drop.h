// Drops as Embree geometry: the analytic surface as a user geometry whose double-precision rays
// travel beside Embree's float ones, and a triangle mesh with smooth normals as the independent
// second way.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

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

// The unit sphere as a subdivided octahedron: 8 * 4^levels triangles. levels: 0 .. 9.
struct SphereMesh {
  std::vector<Eigen::Vector3d> corners = {};
  std::vector<std::array<unsigned, 3>> triangles = {};
  double gap = 0;  // between the sphere and the triangle that lies deepest below it
};
SphereMesh sphere_mesh(int levels);

// The drop at one instant as such a mesh, drawn out to it: corners exactly on the surface, corner
// normals exact, both interpolated linearly. The mesh of the sphere must outlive it.
class MeshDrop {
 public:
  MeshDrop(const DropInstant& drop, const SphereMesh& sphere);
  ~MeshDrop();
  MeshDrop(const MeshDrop&) = delete;
  MeshDrop& operator=(const MeshDrop&) = delete;

  std::size_t triangle_count() const;

  // A ray that starts on the surface must start a little off it (1e-6 of the radius) on its own
  // side.
  std::optional<DropHit> intersect(const Eigen::Vector3d& origin_m,
                                   const Eigen::Vector3d& direction) const;

  // The hit moved along the ray onto the analytic surface, by Newton's method from the triangle's.
  // A ray that starts on that surface must start four gaps off it, or it meets the triangles there.
  // None where the method leaves the neighbourhood, near a grazing ray.
  std::optional<DropHit> intersect_polished(const DropInstant& drop,
                                            const Eigen::Vector3d& origin_m,
                                            const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pluvia
