// From the exit-direction field of a span of time to light in the streak's pixels: every point
// light (a cone of uniform radiance), environments and the coverage, all from the one field.
#pragma once

#include <span>

#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"
#include "raytrace/surface_light.h"

namespace pluvia {

// A moment that stands for a slice of time: the drop as it is then, spread over the rows that it
// passes during the slice.
struct Moment {
  double span_share = 0;  // where in the field's span, 0 .. 1
  Travel travel = {};
  double time_share = 1;  // of the whole exposure
};

// Adds the field's picture to the window's planes: plane k is light k at each of `moments`, then
// come the uniform environment where it is asked for, coverage, and the values of surface_light.h,
// at each of `surface_moments` (ascending both). Values are averages over pixel area and over time:
// lights per unit irradiance on a plane facing them, L = E / (pi sin^2 half_angle) inside the cone
// [1/sr] - a half angle of 0 is that limit: the light comes in glints (raytrace/glints.h, which tells
// what then cannot be promised) -; environments per unit radiance; under a map, radiance.
void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      std::span<const Moment> moments, std::span<const Moment> surface_moments,
                      StreakWindow& window, const EnvironmentRequest& environment = {});

}  // namespace pluvia
