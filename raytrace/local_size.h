// How large the local space must be for a share of the visible rain (lost_share of
// raytrace/rain_space.h), and the pieces of its geometry that both need.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "raytrace/fall_frame.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"

namespace pluvia {

// The rain's box along a unit axis.
Extent box_along(const Rain& rain, const Eigen::Vector3d& axis);

// The slab's lower end: around the camera, but inside the box as far as that can be.
double slab_floor_m(double camera_m, double height_m, const Extent& box);

// One frame for all velocities of one direction, in their order.
std::vector<FallFrame> distinct_falls(const std::vector<Eigen::Vector3d>& velocities);

struct LocalSize {
  double radius_m = 0, height_m = 0;
  double lost_share = 0;
};

// What the scene names, and for what it leaves open the least that keeps rain.lost_share. The scene
// has rain.
LocalSize choose_local_size(const Scene& scene);

}  // namespace pluvia
