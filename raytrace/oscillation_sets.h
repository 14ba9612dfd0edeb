// The ways in which the drops of a database oscillate: numbered sets of modes, from a TOML file of
// their own.
#pragma once

#include <string>
#include <vector>

#include "oscillation/drop_shape.h"
#include "raytrace/toml_reader.h"

namespace pluvia {

// Preset gn2006 has A20 and A31 alone, preset physical `modes` alone.
struct OscillationSet {
  int index = 0;
  double a20 = 0, a31 = 0;
  double phi_drop_deg = 0;  // relative to the view, of all modes with m > 0
  std::vector<Mode> modes = {};
};

// A factor on every amplitude of a set, by the drop's diameter: linear between the rows, constant
// beyond them, 1 without any.
struct AmplitudeFactor {
  std::vector<double> diameter_m = {};  // ascending
  std::vector<double> factor = {};
};
double amplitude_factor(const AmplitudeFactor& table, double diameter_m);

// The set's modes of amplitude other than 0, amplitudes times the factor.
std::vector<Mode> shape_modes(const OscillationSet& set, double factor = 1);

// One [[set]] of a file for gn2006: index, A20, A31, phi_drop_deg; or for physical: index,
// phi_drop_deg and [[set.mode]] with n 2 .. 10, m 0 .. n, amplitude -1 .. 1, phase_deg (0 without).
OscillationSet read_gn2006_set(TomlReader& table);
OscillationSet read_physical_set(TomlReader& table);

// [amplitude_factor] diameters_mm and factors, as many of each.
AmplitudeFactor read_amplitude_factor(TomlReader table);

// Lights beyond azimuth 180 are served by the mirrored drop (atlas/atlas_lookup.h): throws
// std::runtime_error "FILE: set K: .." unless each set's mirror image is the set that the rule
// names.
void refuse_wrong_mirrors(const std::string& file, const std::vector<OscillationSet>& sets);

}  // namespace pluvia
