// What every user of Embree needs: the device and a ray.
#pragma once

#include <embree3/rtcore.h>
#include <Eigen/Core>

namespace pluvia {

// One for the process: starting one takes longer than tracing a drop. Throws std::runtime_error
// when Embree cannot start.
RTCDevice embree_device();

// Rounded to float; the end is not rounded down. far_m may be infinite.
RTCRayHit make_rayhit(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                      double far_m);

}  // namespace pluvia
