// From the exit-direction field of a span of time to light in the streak's pixels: every point
// light (a cone of uniform radiance), environments and the coverage, all from the one field.
#pragma once

#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"
#include "raytrace/surface_light.h"

namespace pluvia {

// A field's span, cut into slices of time: in each the drop is taken as it is in the middle, and
// spread over the rows that it passes. A patch of the field has as many slices as its map needs:
// directions that move through the cone in one of them would leave gaps between pictures of the
// light.
struct SpanSlices {
  Travel travel = {};     // of the drop's centre during the span
  double time_share = 1;  // of the whole exposure
  // Of the span, >= 1: about, since each of the field's cells of time has a whole number of them.
  double most = 1;
  // How far directions may move in a slice, as a share of the cone's half angle, over the patch's
  // importance, and the surface, in pixels. 0: always as many slices as there may be.
  double motion_tolerance = 0.5;
  bool shifted = false;  // by half a slice: the first and the last of each cell are halves
};

// Adds the field's picture to the window's planes: plane k is light k, then come the uniform
// environment where it is asked for, coverage, and the values of surface_light.h. Values are
// averages over pixel area and over time: lights per unit irradiance on a plane facing them, L = E
// / (pi sin^2 half_angle) inside the cone [1/sr] - a half angle of 0 is that limit: the light comes
// in glints (raytrace/glints.h, which tells what then cannot be promised) -; environments per unit
// radiance; under a map, radiance.
void integrate_lights(const ExitField& field, const ConeLights& lights, const StreakFrame& frame,
                      const SpanSlices& slices, StreakWindow& window,
                      const EnvironmentRequest& environment = {});

}  // namespace pluvia
