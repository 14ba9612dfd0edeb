// Raindrop size distributions: how many drops of which size a rain rate means, how much water they
// carry and how much light they take from a beam.
//
//   R     = (pi / 6) int v(D) D^3 N(D) dD          rain rate, v = Beard's fall speed at 20 C
//   sigma = (pi / 4) Q int D^2 N(D) dD             extinction, 1/m
// Q = 2 by the extinction paradox; half of it is diffraction within about 0.02 degrees, which a
// camera cannot tell from the direct beam: what a picture loses is Q = 1.
//
// Marshall and Palmer 1948 (J. Meteorol. 5, 165): N = 8000 exp(-4.1 R^-0.21 D), D in mm, N per m^3
// and mm. Willis 1984 (J. Atmos. Sci. 41, 1648) as a gamma law, mu = 2.5. Neither gives back the
// rate it is named after (Marshall and Palmer: 11.6 for 10 mm/h): N is rescaled so that it does.
#pragma once

#include <vector>

namespace pluvia {

enum class SizeLaw { marshall_palmer, willis };

struct SizeDistribution {
  SizeLaw law = SizeLaw::marshall_palmer;
  double rate_mm_h = 10;  // 0.01 .. 300
};

// Beyond 7 mm (Beard's limit; larger drops break up) there are none.
constexpr double largest_diameter_m = 7e-3;

// N(D), per m^3 of air and m of diameter, rescaled as above. 0 outside (0, largest]. Throws
// std::invalid_argument for a rate out of range.
std::vector<double> drops_per_m4(const SizeDistribution& rain,
                                 const std::vector<double>& diameters_m);

struct SizeClass {
  double diameter_m = 0;  // of equal cross-section: sqrt(mean of D^2)
  double drops_per_m3 = 0;
  double fall_speed_m_s = 0;  // of that diameter
};

// The drops of at least `least_m` (0 < least < largest) in `count` (1 .. 16) classes of equal
// extinction, ascending: together they have its number and its extinction exactly.
std::vector<SizeClass> size_classes(const SizeDistribution& rain, int count, double least_m);

// sigma for Q = 1, of all drops of at least `least_m`, 1/m.
double extinction_per_m(const SizeDistribution& rain, double least_m = 0);

}  // namespace pluvia
