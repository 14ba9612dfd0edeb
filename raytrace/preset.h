// What a database is made of: read from a preset (data/presets/*.toml).
#pragma once

#include <string>
#include <vector>

#include "raytrace/streak_tracer.h"

namespace pluvia {

// r0 (1 + A20 sin(w2 t) P20 + A31 sin(w3 t) P31 cos(phi - phi_drop)); phi_drop relative to the
// view.
struct OscillationSet {
  int index = 0;
  double a20 = 0, a31 = 0;
  double phi_drop_deg = 0;
};

struct Preset {
  std::string name = {};  // "gn2006", the one layout known so far
  std::vector<OscillationSet> sets = {};
  std::vector<int> oscillations = {};         // indices of the sets to trace
  std::vector<int> view_elevations_deg = {};  // 0 .. 80
  double mean_radius_m = 0;
  double density_kg_m3 = 0;
  double surface_tension_n_m = 0;
  double exposure_s = 0;
  double fall_speed_m_s = 0;
  double cone_half_angle_deg = 0;
  int width_px = 0;  // a power of two, 4 .. 64
  int slices = 0;    // per replicate
  double spans_per_period = 0;  // of the fastest mode
  FieldOptions field = {};
  unsigned long long seed = 0;
};

// Throws std::runtime_error with FILE:LINE:COL (raytrace/toml_reader.h), also for a set whose drop
// comes nearer than smallest_relative_radius to its centre, and for a fall longer than the picture
// is high.
Preset read_preset(const std::string& file);

// Every parameter that decides a shard's bytes, as a JSON object's text with sorted keys. Which
// views and oscillations are traced is not among them: a database may grow.
std::string preset_parameters(const Preset& preset);

// The picture of the 2006 database: 16 px wide heights 525, 494, 405, 272, 108 for elevations 0,
// 20, 40, 60, 80 (other widths in proportion, rounded up), the drop's radius 5.6 px of 16, its
// centre entering 9 px of 16 below the top. In between, heights follow 507 cos(elevation) + 18,
// rounded up.
StreakFrame gn2006_frame(const Preset& preset, int view_elevation_deg);

// The set of that index. Throws std::invalid_argument when the preset has none.
const OscillationSet& set_of(const Preset& preset, int oscillation);

// The tracer's request for one shard; the oscillation is an index of preset.sets' `index`.
StreakRequest shard_request(const Preset& preset, const ShardKey& key);

}  // namespace pluvia
