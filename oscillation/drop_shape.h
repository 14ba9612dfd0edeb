// A falling drop that oscillates:
//
//   r(t, theta, phi) = r0 (1 + sum_k c_k cos(k theta)
//                  + sum_i A_i sin(w_i t + p_i) P_{n_i,m_i}(cos theta) cos(m_i (phi - phi_drop)))
//
// Modes: Garg and Nayar, "Photorealistic Rendering of Rain Streaks", SIGGRAPH 2006, after Frohn and
// Roth. Equilibrium terms c_k: Chuang and Beard 1990 (oscillation/equilibrium.h). P_{n,m}:
// associated Legendre function, unnormalised, without the (-1)^m sign. Drop frame: theta from +z
// (against the fall), phi from +x. SI units, radians. Pure functions, thread-safe.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "oscillation/harmonic_surface.h"

namespace pluvia {

struct Mode {
  int n = 2;             // degree, 2 .. 10 (n = 1 only moves the drop)
  int m = 0;             // order, 0 .. n
  double amplitude = 0;  // A, relative to r0
  double phase_rad = 0;  // p
};

struct DropShape {
  double mean_radius_m = 1e-3;               // r0, > 0
  std::vector<Mode> modes = {};              // empty: it does not change in time
  double phi_drop_rad = 0;                   // direction of all modes with m > 0
  std::vector<double> equilibrium_cos = {};  // c_0 .. c_10; empty: a sphere
  bool keep_volume = false;                  // scale r0 at each instant to the volume 4/3 pi r0^3
  bool keep_centroid = false;           // move the surface so that its centroid stays at the origin
  double density_kg_m3 = 998.2;         // rho, water at 20 C
  double surface_tension_n_m = 0.0728;  // sigma, water at 20 C in air
};

// The drop at one instant. The surface is star-shaped about `origin_m`, which is zero unless the
// centroid is kept.
struct DropInstant {
  HarmonicSurface<double> surface = {};
  Eigen::Vector3d origin_m = {0, 0, 0};
  double bound_h = 1;      // |h| <= bound_h
  double bound_slope = 0;  // |dh/d psi| along any great circle (Bernstein: n times the amplitude)
  double bound_bend = 0;   // |d2h/d psi2| likewise (n^2 times)
};

// w of a mode of degree n >= 2 (Rayleigh 1879): sqrt(n (n-1) (n+2) sigma / (rho r0^3)).
template <typename T>
T mode_frequency_rad_s(const T& mean_radius_m, double density_kg_m3, double surface_tension_n_m,
                       int n) {
  using std::pow, std::sqrt;
  assert(n >= 2);
  return sqrt(n * (n - 1) * (n + 2) * surface_tension_n_m /
              (density_kg_m3 * pow(mean_radius_m, 3.0)));
}
double mode_frequency_rad_s(const DropShape& drop, int n);

DropInstant drop_at(const DropShape& drop, double time_s);

// True when the surface is the same at all times.
bool is_rigid(const DropShape& drop);

// Distance from the star centre to the surface in direction (theta, phi). Negative where the
// amplitudes overwhelm the sphere.
double surface_radius_m(const DropInstant& drop, double theta_rad, double phi_rad);

// The same for a unit direction.
double surface_radius_m(const DropInstant& drop, const Eigen::Vector3d& direction);

// Outward unit normal where the ray from the star centre in unit direction u meets the surface.
Eigen::Vector3d surface_normal(const DropInstant& drop, const Eigen::Vector3d& u);

// Product of the principal curvatures [1/m^2]; > 0 where the surface is convex or concave, < 0 on
// saddles.
double gaussian_curvature_1_m2(const DropInstant& drop, const Eigen::Vector3d& u);

// Smallest of surface_radius_m over all directions (grid, then Newton: relative error below 1e-9).
double minimum_radius_m(const DropInstant& drop);

// The smallest minimum_radius_m / r0 over `steps` equally spaced instants of [0, duration_s].
double minimum_relative_radius(const DropShape& drop, double duration_s, int steps = 64);

// Exact quadrature of the polynomial: V = int r^3 / 3, centroid = int r^4 / 4 u / V.
double volume_m3(const DropInstant& drop);
Eigen::Vector3d centroid_m(const DropInstant& drop);

}  // namespace pluvia
