// What a light of a scene does to a point: direction and irradiance. The one formula for surfaces
// and drops, in C++ and (realtime/shaders/lights.glsl, tested against this) in GLSL.
#pragma once

#include <Eigen/Core>

#include "raytrace/scene.h"

namespace pluvia {

// Cosines of a spot's half-angles, the outer at least 1e-6 below the inner.
struct SpotCosines {
  double inner = 1, outer = 0;
};
SpotCosines spot_cosines(const Light& light);

struct Illumination {
  Eigen::Vector3d toward = {0, 0, 1};  // the light, unit
  double distance_m = 0;               // to its centre; infinite for the sun
  Eigen::Vector3d lux = {0, 0, 0};     // on a plane that faces the light, without shadows
};

// Point: I / max(d, radius, 1 mm)^2. Spot: that times t^2, t = the cosine between its axis and the
// point, over 0 .. 1 from the outer half-angle to the inner (KHR_lights_punctual). Sun: its
// illuminance, anywhere. `toward` is (0, 0, 1) at the centre of a lamp.
Illumination illumination(const Light& light, const Eigen::Vector3d& at_m);

// Whether a drop there would be inside the lamp: such drops are not drawn.
bool inside_lamp(const Light& light, const Illumination& lit, double drop_radius_m);

}  // namespace pluvia
