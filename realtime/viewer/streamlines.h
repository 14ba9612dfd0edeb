// Lines along a wind, for the viewer to draw, and turns of its primitives as a hand sets them.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"
#include "raytrace/wind_field.h"

namespace pluvia {

using Streamline = std::vector<Eigen::Vector3d>;

// From a place down the wind by steps of that length (the classical method of Runge and Kutta along
// the wind's direction), until it leaves the box or the air stands: below 1 mm/s.
Streamline streamline(const Wind& steady, const Eigen::Vector3d& from_m, double step_m, int steps,
                      const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m);

// Those of a rain's wind at a time: from a lattice in its box, and from a ring about the foot of
// each primitive that has an axis.
std::vector<Streamline> wind_lines(const Rain& rain, double time_s);

// An axis from the vertical and clockwise from north, as a compass has it.
struct Turn {
  double tilt_deg = 0, heading_deg = 0;
};
Turn turn_of(const Eigen::Vector3d& axis);
Eigen::Vector3d axis_of(const Turn& turn);

}  // namespace pluvia
