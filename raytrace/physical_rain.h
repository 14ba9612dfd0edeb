// What only the preset "physical" has: drops of many diameters that fall at their own speed and
// oscillate about their own flattened shape, water of a temperature, light of chosen wavelengths.
#pragma once

#include <string>
#include <vector>

#include "atlas/streak_database.h"
#include "oscillation/equilibrium.h"
#include "oscillation/fall_speed.h"
#include "raytrace/oscillation_sets.h"

namespace pluvia {

struct PhysicalRain {
  std::vector<int> diameters_um = {};  // those to trace, ascending, 10 .. 7000 (Beard's limit)
  Air air = {};                        // the drop has the air's temperature
  std::vector<Band> bands = {};        // ascending by name; at least one
  EquilibriumTable equilibrium = {};   // no rows: the modes act on a sphere
  bool keep_volume = true;             // oscillation/drop_shape.h
  bool keep_centroid = true;
  AmplitudeFactor amplitude = {};
  double span_s = 0;  // of oscillation time and fall that a picture covers, >= exposure_s
  double slices_per_row = 0;
  double slices_per_period = 0;  // of a set's fastest mode
};

// The tables of a preset file that are this preset's own; each function reads a part of `rain`.
//   [drop]      diameters_mm (list), temperature_c (0 .. 50: water), pressure_pa,
//               equilibrium_file (Chuang and Beard's table; none: spheres), keep_volume,
//               keep_centroid
//   [light]     one of wavelength_nm (589 when none is given), bands = "rgb", [[light.band]] with
//               name and wavelength_nm (300 .. 1100, in vacuum)
// Throw std::runtime_error with FILE:LINE:COL.
void read_physical_drop(TomlReader drop, PhysicalRain& rain);
void read_bands(TomlReader& light, PhysicalRain& rain);

// The three wavelengths of "rgb": where the (signed) matching functions of linear Rec.709 primaries
// have their mean, 634, 545 and 437 nm. The index there is within 2e-4 of the mean over the band.
std::vector<Band> rgb_bands();

// Everything above that decides a shard's bytes, as a JSON object's text: not which diameters.
std::string physical_parameters(const PhysicalRain& rain);

// The drop of a set at rest at that size: modes, equilibrium, what is kept. A set without modes on
// a sphere has no sums at all.
DropShape physical_drop(const PhysicalRain& rain, const OscillationSet& set, int diameter_um);

// Slices of time that a picture of the whole span over path_rows rows needs at most: enough for
// each row, and for each period of the drop's fastest mode.
int slices_needed(const PhysicalRain& rain, const DropShape& drop, double path_rows);

// No point of the drop is farther from its centre at any time, whatever the phases; at most 10 %
// too large for the shipped sets.
double drop_reach_m(const DropShape& drop);

// No point of the drop comes nearer to its star centre, over r0, at any time; not the greatest such
// number, and perhaps negative.
double least_relative_radius(const DropShape& drop);

}  // namespace pluvia
