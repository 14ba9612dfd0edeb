// Real spherical harmonics, orthonormal over the sphere:
//
//   Y_lm = N_lm P_l|m|(z) {sqrt(2) cos m phi (m > 0), 1 (m = 0), sqrt(2) sin |m| phi (m < 0)}
//   N_lm = sqrt((2 l + 1) / (4 pi) (l - |m|)! / (l + |m|)!)
//
// P_lm: associated Legendre function without the (-1)^m sign, so that Y_1m is sqrt(3 / (4 pi))
// times y, z, x for m = -1, 0, 1. phi runs from +x to +y. A function of degree L has (L + 1)^2
// coefficients; that of (l, m) stands at harmonic_index(l, m).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace pluvia {

constexpr int highest_harmonic_degree = 8;

constexpr std::size_t harmonic_count(int degree) {
  return static_cast<std::size_t>((degree + 1) * (degree + 1));
}

constexpr std::size_t harmonic_index(int l, int m) {
  return static_cast<std::size_t>(l * l + l + m);
}

// All Y_lm of degrees 0 .. degree at a unit direction; values.size() == harmonic_count(degree),
// degree in 0 .. highest_harmonic_degree. Polynomials in x, y, z: no trigonometry, no poles.
void real_harmonics(int degree, const Eigen::Vector3d& direction, std::span<double> values);

// Coefficients of the function turned about z by an angle from +x to +y: f'(phi) = f(phi - angle).
// coefficients.size() is a harmonic_count.
std::vector<double> turned_about_z(std::span<const double> coefficients, double angle_rad);

// The matrix that takes a function's coefficients to those of the function turned by a rotation,
// f'(d) = f(rotation^T d): harmonic_count(degree) on a side, a block for each degree. Exact to
// rounding: integrals of products of degree 2 L, by Gauss' rule in z and equal steps in phi.
Eigen::MatrixXd turning_matrix(int degree, const Eigen::Matrix3d& rotation);

}  // namespace pluvia
