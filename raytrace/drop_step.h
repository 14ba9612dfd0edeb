// One step of one drop in moving air, and what it meets on its way.
//
// Drag. With u the drop's velocity relative to the air, v the size's terminal speed in still air
// (oscillation/fall_speed.h), g gravity along its fall:
//   du/dt = g - (|g| / v^2) |u| u
// quadratic drag (as at the Reynolds numbers of rain, 100 to 5000), with the coefficient of the
// terminal speed at every speed; exact at rest in the air and at terminal speed. What it leaves
// out: the change of drag with the Reynolds number (drops below 1 mm), lift, added mass (0.1 %),
// and break-up in strong shear.
//
// Step. The wind stands still for the step: u' = u + (1 - exp(-k t)) / k (g - k u), exact for a
// constant k. k is |g| / v^2 times the speed after half a step of the implicit Euler method, whose
// quadratic equation has one root: of second order in t. Terminal speed is kept exactly. k > 0, so
// that |u'| <= max(|u|, |g| / k) and |u'| <= |u| + |g| t: stable for every t and every wind.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "raytrace/top_height.h"

namespace pluvia {

// Of a drop after step_s > 0. fall_m_s: its terminal velocity in still air, not zero.
Eigen::Vector3d dragged_m_s(const Eigen::Vector3d& velocity_m_s, const Eigen::Vector3d& wind_m_s,
                            const Eigen::Vector3d& fall_m_s, double step_s);

struct SurfaceHit {
  double share = 0;                    // of the way, 0 .. 1
  Eigen::Vector3d normal = {0, 0, 1};  // unit, out of the surface
};

// Where the straight way from one place to another first meets the surface of top heights over the
// world's x and y: the planes of its texels and the upright walls between them. Every texel on the
// way is looked at, however long it is. A step from texel to texel lower than the texel is wide is
// part of a slope and has the plane's normal. A way that begins at or below the surface meets it at
// 0.
std::optional<SurfaceHit> first_hit(const TopHeight& top, const Eigen::Vector3d& from_m,
                                    const Eigen::Vector3d& to_m);

// The velocity after a bounce: the part along the normal, if it goes inward, turned over and taken
// times restitution.
Eigen::Vector3d bounced_m_s(const Eigen::Vector3d& velocity_m_s, const Eigen::Vector3d& normal,
                            double restitution);

}  // namespace pluvia
