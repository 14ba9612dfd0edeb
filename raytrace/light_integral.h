// From the exit-direction field of one instant to light in the streak's pixels: every point light
// (a cone of uniform radiance), a uniform environment and the coverage, all from the one field.
#pragma once

#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"

namespace pluvia {

// Adds the field's picture during one slice of time to the window's planes: plane k is light k,
// then the environment, then coverage. Values are averages over pixel area and over the slice,
// times time_share: lights per unit irradiance on a plane facing them, L = E / (pi sin^2
// half_angle) inside the cone [1/sr].
void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      const Travel& travel, double time_share, StreakWindow& window);

}  // namespace pluvia
