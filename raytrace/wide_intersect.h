// Many rays, or many points of the surface, against one drop at once: raytrace/drop_intersect.h in
// the lanes of a vector. Same roots, same certificate: no root is missed, std::logic_error beyond
// walk_step_limit steps.
//
// What a ray gets does not depend on the others. AVX2 and AVX-512 give the same bytes; between them
// and scalar a root differs by what walk_root_tolerance leaves open: 4e-15 / |G'| in psi.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "raytrace/drop_intersect.h"
#include "raytrace/isa.h"

namespace pluvia {

struct DropRay {
  Eigen::Vector3d origin_m = {0, 0, 0};   // relative to the drop's origin
  Eigen::Vector3d direction = {0, 0, 1};  // unit
};

// intersect_drop of every ray. The processor has `isa` (asserted).
std::vector<std::optional<DropHit>> intersect_drop_of(const DropInstant& drop,
                                                      std::span<const DropRay> rays, RaySide side,
                                                      Isa isa);

// A point of the surface, relative to the drop's origin.
struct SurfacePoint {
  Eigen::Vector3d position_m = {0, 0, 0};
  Eigen::Vector3d normal = {0, 0, 1};  // outward, unit
  bool hidden = false;                 // drop_occludes it from the camera, also where it faces away
};

// The points where rays from the star centre in the unit `directions` meet the surface, seen from
// `to_camera` (unit). The processor has `isa` (asserted).
std::vector<SurfacePoint> surface_points_of(const DropInstant& drop,
                                            std::span<const Eigen::Vector3d> directions,
                                            const Eigen::Vector3d& to_camera, Isa isa);

}  // namespace pluvia
