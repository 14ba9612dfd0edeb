// What a raindrop throws up where it hits a wet surface: a crown that rises and falls back, and
// droplets that fly off it. One splash is a function of the drop, of the surface and of the time
// since the hit; nothing is simulated step by step and nothing is stored.
//
// The hit (d diameter, v speed along the surface's normal) has Weber's number We = rho v^2 d /
// sigma. A thin film splashes above sqrt(We) = 20 (Vander Wal, Berger and Mozes, Exp. Fluids 40,
// 53, 2006): at terminal speed, drops of more than 1.26 mm. Below, nothing is thrown.
//
// Assumptions, each with the range that the literature leaves open:
//   droplets        5 (We / 400 - 1), after Bai and Gosman (SAE 950283); half to twice as many;
//                   at most most_splash_droplets, which then share the same mass
//   their mass      0.35 (1 - 400 / We) of the drop's; 0.2 .. 0.8 far above the threshold
//   their radii     log-normal, standard deviation 0.45 of the logarithm
//   their speed     0.22 v where a droplet has the mean volume, more for smaller ones (as
//                   1 / sqrt(radius)), spread by 0.25 of the logarithm; 0.1 .. 0.5 v
//   their elevation 62 degrees from the surface, spread by 8
//   the crown       rim beads of 0.1 of the drop's mass; 4 sqrt(rho d^3 / (8 sigma)) of life; 0.03
//                   sqrt(We) d high; 1 d wide at first, 3 d at last (radii): one to two times each
// Spreads are those of a normal law cut at twice its standard deviation.
// A surface that leans, or rain that slants, is hit with the cosine's share of the speed: fewer
// droplets, slower by the cosine, thrown about the surface's own normal; of the speed along the
// surface they keep splash_drift. What is thrown never has more mass or energy than the drop:
// tests/splash_test.cpp. Water and air at 20 C.
//
// A droplet flies with linear drag, the closed form of
//   x'' = g - x' / tau:   x = (u - g tau) tau (1 - exp(-t / tau)) + g tau t,
// with the tau for which a head-on hit's droplet flies as far as with the full drag of every moment
// (Schiller and Naumann's), found when the tables are made; heights are then within 15 %. Still
// air.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace pluvia {

constexpr double splash_threshold_weber = 400;  // sqrt(We) = 20
constexpr double droplets_a_threshold = 5;      // for each time that We exceeds it
constexpr int most_splash_droplets = 128;
constexpr int crown_beads = 32;
constexpr int splash_variants = 16;
constexpr double splash_drift = 0.2;

// diameter and speed > 0.
double weber_number(double diameter_m, double speed_m_s);

// Mean number of droplets, and their mass in the drop's; 0 up to the threshold.
double thrown_count(double weber);
double thrown_share(double weber);

struct CrownSize {
  double life_s = 0, height_m = 0, first_radius_m = 0, last_radius_m = 0;
};
CrownSize crown_size(double diameter_m, double weber);

// How fast a sphere of water loses its speed in air, s: speed / deceleration at this speed, > 0.
double drag_time_s(double radius_m, double speed_m_s);

struct Flight {  // from a level surface and back to it
  double length_m = 0, height_m = 0;
};
// With the drag of every moment, from its launch along and up (both > 0), in steps of 1 ms.
Flight flight_with_full_drag(double radius_m, double along_m_s, double up_m_s);

struct SplashPart {  // a droplet, or a bead of the crown's rim
  double radius_m = 0;
  Eigen::Vector3d first = {0, 0, 0};         // place at launch; z along the surface's normal
  Eigen::Vector3d velocity_m_s = {0, 0, 0};  // a bead: none
  double delay_s = 0;                        // between hit and launch
  double drag_s = 0;                         // tau; 0 for a bead
};

// Head-on splashes of one size of drop, as they were thrown before anything is drawn: each variant
// has the same number of parts, crown_beads beads first, then droplets, none biggest first, so that
// any first few stand for all. radius_m > 0; none of anything up to the threshold.
struct SplashTable {
  double radius_m = 0, speed_m_s = 0;  // of the drop
  double weber = 0;
  CrownSize crown = {};
  int droplets = 0;                    // of a variant
  std::vector<SplashPart> parts = {};  // [variant (crown_beads + droplets) + i]
};
SplashTable splash_table(double radius_m, double speed_m_s, std::uint32_t seed);

// Droplets thrown by a hit with a share `cosine` (0 .. 1) of the speed along the normal.
int thrown_droplets(const SplashTable& table, int variant, double cosine);

struct SplashHit {                            // in the world, from the point that was hit
  Eigen::Vector3d normal = {0, 0, 1};         // of the surface, unit
  Eigen::Vector3d velocity_m_s = {0, 0, -8};  // of the drop
  double turn_rad = 0;                        // of the variant about the normal
};

// Where a part is, `time_s` after the hit. Before its launch and after it is back on the surface it
// is below it: no part is drawn there.
Eigen::Vector3d splash_place_m(const SplashTable& table, const SplashPart& part,
                               const SplashHit& hit, double time_s);

// No part is above the surface later than that; lean: the greatest ratio of the cosine of hit and
// normal to that of normal and vertical.
double splash_duration_s(const SplashTable& table, double lean);

// No part flies farther from the point that was hit while it is above the surface.
double splash_reach_m(const SplashTable& table, double duration_s);

}  // namespace pluvia
