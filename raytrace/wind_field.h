// Wind made of primitives about axes, after Rousseau, Jolivet and Ghazanfarpour (2006, 2008), with
// a core where theirs are infinite. rho: distance from the axis; c: core radius; e_r, e_t: unit
// vectors away from the axis and around it (counter-clockwise as seen from its tip); G(rho) =
// 1 - exp(-rho^2 / c^2), the core of Lamb and Oseen: linear near the axis, 1 / rho far from it.
//
//   uniform  V = s axis                     divergence 0
//   source   V = a G / (2 pi rho) e_r       a exp(-rho^2 / c^2) / (pi c^2); a < 0: a sink
//   vortex   V = b G / (2 pi rho) e_t       0
//   tornado  the vortex, and below the middle of its height h a sink, above it a source, with the
//            air between them rising in the core: z from its foot along the axis, q = z / h,
//            V = ... - a S'(z) G / (2 pi rho) e_r + a S(z) exp(-rho^2 / c^2) / (pi c^2) axis,
//            S = (686 sqrt(7) / 27) h (q (1 - q))^4, |S'| <= 1; S = 0 outside 0 <= q <= 1;
//            a = inflow |b|: it lifts, whichever way it turns
//                                           divergence 0
//
// All are finite everywhere and smooth, but for the tornado's third derivatives
// at foot and tip.
// The fastest of G / (2 pi rho) is 0.1016 / c, at 1.121 c. Wind is the sum of all. A source has a
// divergence inside its core alone: beyond rho = 5.3 c it is below 1e-12 of that on the axis. SI
// units; pure functions.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace pluvia {

enum class WindKind { uniform, source, vortex, tornado };

struct WindKey {
  double time_s = 0;
  Eigen::Vector3d position_m = {0, 0, 0};
  Eigen::Vector3d axis = {0, 0, 1};  // unit
  double strength = 0;               // as that of the primitive

  bool operator==(const WindKey&) const = default;
};

struct WindPrimitive {
  WindKind kind = WindKind::uniform;
  Eigen::Vector3d position_m = {0, 0, 0};  // of a point of the axis; of a tornado its foot
  Eigen::Vector3d axis = {0, 0, 1};        // unit
  double strength = 0;             // uniform: s in m/s; source: a, vortex and tornado: b, in m^2/s
  double inflow = 0;               // of a tornado: a / |b|
  double core_radius_m = 1;        // c > 0
  double height_m = 10;            // of a tornado: h > 0
  std::vector<WindKey> path = {};  // ascending times; empty: steady

  bool operator==(const WindPrimitive&) const = default;
};

constexpr double widest_turn_rad = 2.967;  // 170 degrees

// The primitive as its path has it: place as raytrace/key_path.h, strength and axis evenly
// along the chord from key to key. Axes of keys one after the other are at most widest_turn_rad
// apart.
WindPrimitive primitive_at(const WindPrimitive& primitive, double time_s);

// Of one steady primitive, and the sum of all as they are at a time over an even wind.
Eigen::Vector3d wind_of(const WindPrimitive& primitive, const Eigen::Vector3d& at_m);
struct Wind {
  Eigen::Vector3d even_m_s = {0, 0, 0};
  std::vector<WindPrimitive> primitives = {};
};
Wind wind_at(const Wind& wind, double time_s);
Eigen::Vector3d velocity_m_s(const Wind& steady, const Eigen::Vector3d& at_m);

// Speed that no place of a primitive exceeds, m/s.
double most_speed_m_s(const WindPrimitive& primitive);

}  // namespace pluvia
