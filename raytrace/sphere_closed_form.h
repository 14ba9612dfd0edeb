// Light from a sphere in closed form: the top rung of the ladder of truth. Geometrical optics with
// the s and p chains kept apart; valid for drops much larger than the wavelength.
//
// A ray that meets the sphere at angle of incidence i (impact b = sin i, sin i = n sin r) leaves
// after p inner segments at total deviation D_p = 2 i - 2 p r + (p - 1) pi  (p >= 1), D_0 = pi - 2
// i, with the share (1 - R)^2 R^(p-1) (p >= 1) or R (p = 0) per polarisation, R = Fresnel's
// reflectance.
#pragma once

namespace pluvia {

// In all functions refractive_index > 1, order >= 0, 0 <= impact <= 1, angles in radians.

// Share of the power, mean of s and p.
double sphere_throughput(double refractive_index, int order, double impact);

// Of a ray, not folded: D_p above. incidence_rad in [0, pi / 2].
double sphere_deviation_rad(double refractive_index, int order, double incidence_rad);

// The angle of incidence between `low` and `high` at which the deviation, monotone there, is
// `deviation_rad`; the nearer end where it is not reached.
double sphere_incidence_rad(double refractive_index, int order, double deviation_rad, double low,
                            double high);

// Scattering angle folded to [0, pi]: 0 is forward.
double sphere_scattering_angle_rad(double refractive_index, int order, double impact);

// Share of the power on the disc pi a^2 that leaves with that order.
double sphere_energy(double refractive_index, int order);

// Scattering angle of the rainbow of order p >= 2: cos^2 i = (n^2 - 1) / (p^2 - 1).
double sphere_rainbow_rad(double refractive_index, int order);

// (d sigma / d Omega) / (pi a^2) [1/sr] of one order at a scattering angle in (0, pi): sum over the
// rays of throughput b / (pi sin angle |d angle / d b|). No bound toward a rainbow, 0 and pi; to
// 1e-9 away from them.
double sphere_order_intensity(double refractive_index, int order, double angle_rad);

// The same, orders 0 .. max_order together,.
double sphere_intensity(double refractive_index, int max_order, double angle_rad);

// The intensity averaged over a light's cone about scattering angle `centre`, per unit irradiance
// on a plane facing the light (radiance 1/(pi sin^2 cone)). cone_half_angle_rad from 0.2 degrees to
// pi / 2. Integrable caustics need no care: the integral is over b^2, where nothing is singular.
double sphere_intensity_in_cone(double refractive_index, int max_order, double centre_rad,
                                double cone_half_angle_rad);

// Where the light of sphere_intensity is seen on the sphere's disc: its mean position along the
// line toward the light, over the radius, -1 .. 1: > 0 on the light's side, < 0 on the other.
double sphere_light_position(double refractive_index, int max_order, double angle_rad);

}  // namespace pluvia
