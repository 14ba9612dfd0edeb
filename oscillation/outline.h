// The outline of a drop in a picture: its true silhouette, not a section through it.
//
// The picture is orthographic. Toward the camera: c = (cos e cos a, cos e sin a, sin e), view
// elevation e, azimuth a in the drop frame (oscillation/drop_shape.h); right = (-sin a, cos a, 0),
// up = c x right. In the picture, at the angle theta from up toward right, d = cos theta up + sin
// theta right, a star-shaped drop reaches as far from its star centre as
//   rho(theta) = max over psi of r(cos psi d + sin psi c) cos psi,   -pi/2 <= psi <= pi/2:
// what the half-plane of d and the line of sight holds of the drop, seen from the side. This holds
// for concave drops too. By the envelope theorem the derivative of rho with respect to a parameter
// of the shape is that of r cos psi at the psi of the maximum, held fixed.
// SI units, radians. Pure functions, thread-safe.
#pragma once

#include <Eigen/Core>

#include "oscillation/harmonic_surface.h"

namespace pluvia {

struct OutlineRay {                       // both unit, at right angles
  Eigen::Vector3d across = {0, 0, 1};     // d: in the picture, from the centre to the outline
  Eigen::Vector3d to_camera = {1, 0, 0};  // c
};

// Any angles; at elevation +-90 degrees the azimuth still turns the picture.
OutlineRay outline_ray(double view_elevation_rad, double view_azimuth_rad, double theta_rad);

// The unit direction cos psi d + sin psi c of the maximum, to 1e-9 rad or better (the distance errs
// by the square of that). Where two maxima are equal, either.
Eigen::Vector3d outline_direction(const HarmonicSurface<double>& surface, const OutlineRay& ray);

// rho. At least 0.
double outline_radius_m(const HarmonicSurface<double>& surface, const OutlineRay& ray);

}  // namespace pluvia
