// The axes of a fall: z points against it, x and y lie across it, right-handed and unit. For a fall
// straight down they are the world's.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pluvia {

struct FallFrame {
  Eigen::Vector3d x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
};

// velocity: not zero.
inline FallFrame fall_frame(const Eigen::Vector3d& velocity) {
  FallFrame frame;
  frame.z = -velocity.normalized();
  // The world's x made perpendicular, or its y where x lies along the fall.
  const Eigen::Vector3d hint =
      std::abs(frame.z.x()) < 0.9 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, -1, 0);
  frame.x = (hint - hint.dot(frame.z) * frame.z).normalized();
  frame.y = frame.z.cross(frame.x);
  return frame;
}

inline bool same_fall(const FallFrame& a, const FallFrame& b) {
  return (a.z - b.z).norm() < 1e-12;
}

}  // namespace pluvia
