// A preset of a test's own, cheap enough to be traced in a fraction of a second.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "atlas/atomic_file.h"

namespace pluvia {

// Line numbers matter to the tests of refusals: add keys at the end of a table.
inline constexpr const char* tiny_preset = R"(preset = "gn2006"
oscillation_file = "sets.toml"
seed = 7

[drop]
mean_radius_m = 1.6e-3
density_kg_m3 = 998.2
surface_tension_n_m = 0.0728
refractive_index = 1.333

[exposure]
exposure_s = 0.016666666666666666
fall_speed_m_s = 8.49

[light]
cone_half_angle_deg = 5
max_order = 2

[picture]
width_px = 4
view_elevations_deg = [80]
oscillations = [0, 3]

[accuracy]
slices = 3
spans_per_period = 1
base_cells = 4
space_depth = 0
time_depth = 0
bend_tolerance = 0.3
motion_tolerance = 0.5
)";

inline constexpr const char* tiny_sets = R"([[set]]
index = 0
A20 = 0.0
A31 = 0.0
phi_drop_deg = 0.0
[[set]]
index = 3
A20 = 0.11
A31 = 0.1
phi_drop_deg = 0.0
)";

// The same for preset "physical": two sizes, two bands, a view from below.
inline constexpr const char* tiny_physical = R"(preset = "physical"
oscillation_file = "sets.toml"
seed = 7

[drop]
diameters_mm = [3, 0.5]
temperature_c = 20
equilibrium_file = "equilibrium.csv"

[exposure]
exposure_s = 0.004
span_s = 0.008

[light]
cone_half_angle_deg = 5
max_order = 2
band = [{ name = "red", wavelength_nm = 650 }, { name = "blue", wavelength_nm = 450 }]

[picture]
width_px = 8
view_elevations_deg = [-80, 80]
oscillations = [0, 3]

[accuracy]
slices_per_row = 0.05
slices_per_period = 3
spans_per_period = 1
base_cells = 4
space_depth = 0
time_depth = 0
bend_tolerance = 0.3
motion_tolerance = 0.5
)";

inline constexpr const char* tiny_physical_sets = R"([[set]]
index = 0
phi_drop_deg = 0
[[set]]
index = 3
phi_drop_deg = 0
mode = [{ n = 2, m = 0, amplitude = 0.1 }, { n = 3, m = 1, amplitude = 0.05, phase_deg = 90 }]
[amplitude_factor]
diameters_mm = [1, 2]
factors = [0, 1]
)";

// `text` with its only `from` replaced; a failure of the test when there is none, or another.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos || text.find(from, at + 1) != std::string::npos) {
    ADD_FAILURE() << "\"" << from << "\" is not there exactly once";
    return text;
  }
  return text.replace(at, from.size(), to);
}

// Returns the preset's file, FOLDER/preset.toml.
inline std::string write_preset(const std::string& folder, const std::string& preset = tiny_preset,
                                const std::string& sets = tiny_sets) {
  write_file_atomically(folder + "/sets.toml", sets);
  write_file_atomically(folder + "/preset.toml", preset);
  return folder + "/preset.toml";
}

// .. for preset "physical", with Chuang and Beard's table beside it.
inline std::string write_physical(const std::string& folder,
                                  const std::string& preset = tiny_physical,
                                  const std::string& sets = tiny_physical_sets) {
  write_file_atomically(folder + "/equilibrium.csv",
                        read_file(PLUVIA_SOURCE_DIR "/data/tables/chuang_beard_1990_cn.csv"));
  return write_preset(folder, preset, sets);
}

}  // namespace pluvia
