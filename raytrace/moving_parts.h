// Parts of a scene's surfaces that move as rigid bodies along paths (raytrace/key_path.h): the
// dynamic top depth map of Creus (2010), "a car drives through the rain". Surfaces are posed at the
// instant at which the shutter opens, and then are what any other surface is: hit, lit, splashed
// on.
//
// What that leaves out:
//   - A part stands still while the shutter is open: it is not blurred.
//   - The rain does not remember: a drop is drawn unless a surface is above it now. A drop that a
//     part has caught is back once the part has moved on, below the height H that the part has
//     there, for as long as the drop would still have fallen: at most H / fall speed (0.17 s behind
//     a car of 1.45 m in drops of 8.5 m/s), and its splash on the ground begins as if in
//     mid-life. Before a part that comes, drops below H end at once: right for a solid body, too
//     early below an open roof.
//   - A splash on a part stays where its drop falls in the world and does not ride along.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"

namespace pluvia {

// Appends a part to scene.mesh, posed at time 0. `shape` is about the part's own origin; path: at
// least one key, times ascending. What stands still must be in the mesh already.
void add_moving_part(Scene& scene, const Mesh& shape, const std::vector<MovingKey>& path);

// Puts the vertices of the moving parts where they are at that time, whatever time they were posed
// at before: position + R(heading) v, in double. Whether any vertex has moved.
bool pose(Scene& scene, double time_s);

// The scene as it is at that time: the camera on its path, the moving parts on theirs, the
// environment at the picture of its clip.
Scene scene_at(Scene scene, double time_s);

// Where the vertices and indices of scene.mesh that never move end.
std::size_t resting_vertices(const Scene& scene);
std::size_t resting_indices(const Scene& scene);

struct Bounds {
  Eigen::Vector3d low_m = {1e300, 1e300, 1e300}, high_m = {-1e300, -1e300, -1e300};

  void add(const Eigen::Vector3d& p) {
    low_m = low_m.cwiseMin(p);
    high_m = high_m.cwiseMax(p);
  }
};

// A box along the world's axes that holds the part at every time.
Bounds reach_of(const MovingPart& part);

// The same of all surfaces; low_m > high_m without any.
Bounds surface_bounds(const Scene& scene);

}  // namespace pluvia
