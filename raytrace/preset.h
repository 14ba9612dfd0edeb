// What a database is made of: read from a preset (data/presets/*.toml).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytrace/oscillation_sets.h"
#include "raytrace/physical_rain.h"
#include "raytrace/streak_tracer.h"

namespace pluvia {

// Two kinds: "gn2006", the database as published (spheres with two modes, one size, monochrome),
// and "physical" (raytrace/physical_rain.h).
struct Preset {
  std::string name = {};
  std::vector<OscillationSet> sets = {};
  std::vector<int> oscillations = {};         // indices of the sets to trace
  std::vector<int> view_elevations_deg = {};  // 0 .. 80; physical -80 .. 80
  double mean_radius_m = 0;                   // gn2006; 0 in physical
  double density_kg_m3 = 0;
  double surface_tension_n_m = 0;
  double exposure_s = 0;
  double fall_speed_m_s = 0;       // gn2006; 0 in physical
  double cone_half_angle_deg = 0;  // 0: points at infinity (raytrace/glints.h); else 0.05 .. 30
  std::vector<LightDirection> lights = light_grid(20);  // of grid_step_deg, or a scene's subset
  bool environment = true;      // write the part env; gn2006: but for a scene without one
  int transfer_degree = -1;     // of the spherical harmonics, 0 .. 8: their parts too; -1: none
  int width_px = 0;             // a power of two, 4 .. 64
  int slices = 0;               // gn2006, per replicate, at most; 0 in physical
  double spans_per_period = 0;  // of the fastest mode
  double motion_tolerance = 0;  // of directions in a slice (raytrace/light_integral.h)
  FieldOptions field = {};
  double target_error = 0;  // > 0: settings are chosen to keep it (streak_accuracy.h)
  unsigned long long seed = 0;
  std::optional<PhysicalRain> physical = {};  // there when, and only when, name is "physical"
};

// Throws std::runtime_error with FILE:LINE:COL (raytrace/toml_reader.h), also for a set whose drop
// comes nearer than smallest_relative_radius to its centre, for a fall longer than the picture of
// gn2006 is high, and for a picture of more than 2^20 rows.
Preset read_preset(const std::string& file);

// Every parameter that decides a shard's bytes, as a JSON object's text with sorted keys. Which
// views, oscillations and diameters are traced is not among them: a database may grow. Which lights
// are traced is, where they are not all 74: cells are refined where a light looks, so other lights
// change the bytes.
std::string preset_parameters(const Preset& preset);

// The picture of the 2006 database: 16 px wide heights 525, 494, 405, 272, 108 for elevations 0,
// 20, 40, 60, 80 (other widths in proportion, rounded up), the drop's radius 5.6 px of 16, its
// centre entering 9 px of 16 below the top. In between, heights follow 507 cos(elevation) + 18,
// rounded up.
StreakFrame gn2006_frame(const Preset& preset, int view_elevation_deg);

// The picture of a drop of `physical`. The same for all of the preset's sets, so that they can be
// packed beside each other: width_px - 2 columns hold twice the reach of the set that reaches
// farthest (drop_reach_m), the centre enters width_px / 2 rows below the top and the picture ends
// width_px / 2 below the end of the path, rounded up. The path is that of the span.
StreakFrame physical_frame(const Preset& preset, int diameter_um, int view_elevation_deg);

// The one of the two that the preset calls for.
StreakFrame shard_frame(const Preset& preset, const ShardKey& key);

// What belongs to a diameter. gn2006 has one diameter: the argument is only copied.
SizeRecord size_of(const Preset& preset, int diameter_um);

// In um, ascending: those to trace.
std::vector<int> diameters_of(const Preset& preset);

// At least one, ascending names. gn2006: Y, of no wavelength.
std::vector<Band> bands_of(const Preset& preset);

// Of its bands: for light whose colours are not split.
double mean_refractive_index(const Preset& preset);

// The set of that index. Throws std::invalid_argument when the preset has none.
const OscillationSet& set_of(const Preset& preset, int oscillation);

// The drop of one of the preset's sets.
DropShape drop_of(const Preset& preset, const OscillationSet& set, int diameter_um);

// Of time that a picture shows [s].
double span_of(const Preset& preset);

// How near the drop's surface comes to its centre within a time, over r0, where that is not farther
// than smallest_relative_radius.
std::optional<double> too_near_surface(const DropShape& drop, double span_s);

// The drop of a set of that mean radius, which need not be one of the preset's: what scenes are
// full of. oscillation: an index of preset.sets' `index`; r0_m > 0. Throws std::runtime_error where
// the amplitudes overwhelm it (as read_preset), std::invalid_argument for a set that is not there.
DropShape drop_shape(const Preset& preset, int oscillation, double r0_m);

// The tracer's request for one shard and band (index into bands_of); the oscillation is an index of
// preset.sets' `index`.
StreakRequest shard_request(const Preset& preset, const ShardKey& key, int band = 0);

}  // namespace pluvia
