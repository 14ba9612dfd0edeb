// Model B: a rain drop taken for a sphere, whose brightness is a transfer function of the
// scattering angle alone (Wang, Lin, Fang, Wei and Guo, "Real-Time Rendering of Realistic Rain",
// MSR-TR-2006-102):
//
//   brightness of the disc, mean over it = integral D(angle) L(light) d light        [cd/m^2]
//   D(angle) = (d sigma / d Omega) / (pi a^2)                                         [1/sr]
//
// The angle is that between the ways of the light before and after the drop: 0 where the light
// shines through it into the eye, cos angle = -(toward the light) . (toward the eye).
//
// D has no bound at rainbows, at 0 and at pi, but its integral has: what is given here are means
// over rings of angle, whose energy is integrated over the angle of incidence, where nothing is
// singular. So all values are finite, and their integral over the sphere is 1 less the orders left
// out. Away from those angles D itself is sphere_order_intensity (raytrace/sphere_closed_form.h).
//
// The published formula differs in two things, which are kept as options to show what they cost:
// reflectance averaged over s and p at each bounce (8 % too bright at order 2), and one ray for
// each angle where there are several (light is lost inside the bows).
#pragma once

#include <vector>

#include <Eigen/Core>

namespace pluvia {

struct SphereTransferOptions {
  double refractive_index = 1.333;    // > 1
  int terms = 9;                      // >= 1; orders 0 .. terms - 1; nine leave 1.8e-4 out
  bool averaged_reflectance = false;  // as published; else chains of s and of p
  bool single_root = false;           // as published: of several rays the one nearest the axis
};

// Means of D over `bins` >= 1 rings of equal width from 0 to pi, 1/sr.
std::vector<double> sphere_transfer(const SphereTransferOptions& options, int bins);

// The table at an angle in [0, pi]: linear between the middles of its rings, constant beyond the
// first and last.
double transfer_at(const std::vector<double>& table, double angle_rad);

// What D does to a harmonic of degree l: under radiance Y_lm the disc's brightness is
// k_l Y_lm(straight on from the eye), k_l = integral D(angle) P_l(cos angle) d Omega (Funk and
// Hecke). k_0 is the share of light that the terms hold. Returns k_0 .. k_degree, degree >= 0.
std::vector<double> transfer_harmonics(const SphereTransferOptions& options, int degree);

// Coefficients of D seen from a direction, in real harmonics (raytrace/spherical_harmonics.h), so
// that brightness = sum_lm coefficient_lm L_lm, L_lm those of the light around. A zonal function
// needs no rotation matrix: coefficient_lm = k_l Y_lm(-to_eye). to_eye: unit.
Eigen::VectorXd transfer_seen_from(const std::vector<double>& harmonics,
                                   const Eigen::Vector3d& to_eye);

}  // namespace pluvia
