// Reflection and refraction at a smooth interface, with polarisation carried along.
//
// A Beam holds the electric field that unit unpolarised light makes: two orthogonal, mutually
// incoherent input polarisations, each a complex vector perpendicular to the direction. At an
// interface the field is split into its parts perpendicular (s) and parallel (p) to the plane of
// incidence, so a turn of that plane between two interfaces needs no extra step. Amplitudes are
// power-normalised: |r|^2 + |t|^2 = 1 for s and for p, on every interface; the share of power in a
// beam is half the sum of the squares. Born and Wolf, Principles of Optics, section 1.5. Indices of
// refraction are real.
#pragma once

#include <Eigen/Core>

namespace pluvia {

struct Beam {
  Eigen::Vector3d direction = {0, 0, 1};                                    // unit
  Eigen::Matrix<double, 3, 4> field = Eigen::Matrix<double, 3, 4>::Zero();  // Re1, Im1, Re2, Im2
};

// Unpolarised light of unit power.
Beam unpolarised_beam(const Eigen::Vector3d& direction);

// Share of the initial power, 0 .. 1.
double power(const Beam& beam);

struct Split {
  double power_s = 0, power_p = 0;  // of the incident beam, in the two parts; their sum is its power
  Beam reflected = {};
  Beam refracted = {};  // where totally_reflected: no field, along the surface
  bool totally_reflected = false;
};

// The beam meets an interface whose unit normal points against it (normal . direction < 0);
// index_ratio = n(beam's side) / n(far side), > 0. Index ratio 1 transmits everything unchanged,
// whatever the normal.
//
// With normal . direction >= 0 the result is the analytic continuation of these formulas past
// grazing incidence, where no light meets the interface: directions go on smoothly; the reflected
// share exceeds 1, and the refracted share is the negative of the power that `refracted` holds, so
// that the two still add up to 1. Both grow without bound toward a pole at normal . direction = 1 /
// sqrt(1 + 1 / index_ratio^2), where there is no result; for ratios near 1 they are large long
// before.
Split split_at_interface(const Beam& beam, const Eigen::Vector3d& normal, double index_ratio);

// The direction alone of the refracted beam; along the surface where reflection is total.
Eigen::Vector3d refracted_direction(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                    double index_ratio);

// Squared cosine of refraction: negative where reflection is total, and analytic across that edge.
double squared_cosine_refracted(double cos_incidence, double index_ratio);

struct FresnelPower {
  double s = 0, p = 0;  // reflected share of power
};

// Total reflection gives 1, 1; cos_incidence < 0 the continuation past grazing (above 1).
FresnelPower fresnel_reflectance(double cos_incidence, double index_ratio);

}  // namespace pluvia
