// The exits of many camera hits on one drop at once: raytrace/exit_paths.h with several paths side
// by side in the lanes of a vector (AVX2: 4, AVX-512: 8). A lane never looks at its neighbours, so
// a hit's exits are the same bytes in whatever batch it comes. Needs nothing built per instant.
//
// AVX2 and AVX-512 give the same bytes: both do the same correctly rounded operations (add,
// multiply, fused multiply-add, divide, root) in each lane. They differ from scalar by rounding:
// directions and throughputs by less than the scalar tracer's own change when the hit moves by
// 1e-12 r0 and its normal by 1e-12; up to order 3 that is below 1e-12 for all but one hit in a
// thousand (docs/generator.md), also on concave drops. A hit that stands on a break of its map to
// that distance (total reflection, tangent, min_power) may have the exits of either side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "oscillation/drop_shape.h"
#include "raytrace/exit_paths.h"
#include "raytrace/isa.h"

namespace pluvia {

// Where a camera's ray meets the drop, relative to the drop's origin as trace_exits takes it.
struct CameraHit {
  Eigen::Vector3d position_m = {0, 0, 0};
  Eigen::Vector3d normal = {0, 0, 1};  // outward, unit
};

// Exits of hit k: exits[first_exit[k]] up to exits[first_exit[k + 1]], in a fixed order (not that
// of trace_exits).
struct HitExits {
  std::vector<std::uint32_t> first_exit = {0};  // one more than there are hits
  std::vector<PathExit> exits = {};
  PathRemainder remainder = {};  // summed over the hits, in their order
};

// `to_camera` unit; the processor has `isa` (asserted). Thread-safe. A single hit costs as much as
// with scalar; full speed from about 16 hits in a batch.
HitExits trace_exits_of(const DropInstant& drop, std::span<const CameraHit> hits,
                        const Eigen::Vector3d& to_camera, const PathOptions& options, Isa isa);

}  // namespace pluvia
