#include "raytrace/oscillation_sets.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atlas_lookup.h"

namespace pluvia {

namespace {

Mode read_mode(TomlReader table) {
  Mode mode;
  double phase_deg = 0;
  table.required("n", mode.n, 2, 10);
  table.required("m", mode.m, 0, mode.n);
  table.required("amplitude", mode.amplitude, {-1, 1});
  table.optional("phase_deg", phase_deg, {-360, 360}, "deg");
  table.finish();
  mode.phase_rad = phase_deg * std::numbers::pi / 180;
  return mode;
}

// cos m (phi - phi_drop) mirrored is cos m (phi + phi_drop): the same where m times the sum of both
// directions is a whole number of turns.
bool mirrors(const OscillationSet& set, const OscillationSet& other) {
  const std::vector<Mode> modes = shape_modes(set), others = shape_modes(other);
  const auto same = [&](const Mode& a, const Mode& b) {
    const double turn_deg = a.m * (set.phi_drop_deg + other.phi_drop_deg);
    return a.n == b.n && a.m == b.m && a.amplitude == b.amplitude && a.phase_rad == b.phase_rad &&
           std::abs(std::remainder(turn_deg, 360)) < 1e-9;
  };
  return std::equal(modes.begin(), modes.end(), others.begin(), others.end(), same);
}

}  // namespace

double amplitude_factor(const AmplitudeFactor& table, double diameter_m) {
  const auto& d = table.diameter_m;
  if (d.empty()) return 1;
  if (diameter_m <= d.front()) return table.factor.front();
  if (diameter_m >= d.back()) return table.factor.back();
  const auto above =
      static_cast<std::size_t>(std::upper_bound(d.begin(), d.end(), diameter_m) - d.begin());
  const double w = (diameter_m - d[above - 1]) / (d[above] - d[above - 1]);
  return (1 - w) * table.factor[above - 1] + w * table.factor[above];
}

std::vector<Mode> shape_modes(const OscillationSet& set, double factor) {
  std::vector<Mode> modes = {{.n = 2, .m = 0, .amplitude = set.a20},
                             {.n = 3, .m = 1, .amplitude = set.a31}};
  modes.insert(modes.end(), set.modes.begin(), set.modes.end());
  for (Mode& mode : modes) mode.amplitude *= factor;
  std::erase_if(modes, [](const Mode& mode) { return mode.amplitude == 0; });
  return modes;
}

OscillationSet read_gn2006_set(TomlReader& table) {
  OscillationSet set;
  table.required("index", set.index, 0, 99);
  table.required("A20", set.a20, {-1, 1});
  table.required("A31", set.a31, {-1, 1});
  table.required("phi_drop_deg", set.phi_drop_deg, {-360, 360}, "deg");
  table.finish();
  return set;
}

OscillationSet read_physical_set(TomlReader& table) {
  OscillationSet set;
  table.required("index", set.index, 0, 99);
  table.required("phi_drop_deg", set.phi_drop_deg, {-360, 360}, "deg");
  for (const TomlReader& mode : table.tables("mode")) set.modes.push_back(read_mode(mode));
  table.finish();
  return set;
}

AmplitudeFactor read_amplitude_factor(TomlReader table) {
  AmplitudeFactor result;
  table.required("diameters_mm", result.diameter_m, {0, 9, true}, "mm");
  table.required("factors", result.factor, {0, 10});
  table.finish();
  for (double& d : result.diameter_m) d *= 1e-3;
  const auto& d = result.diameter_m;
  if (std::adjacent_find(d.begin(), d.end(), std::greater_equal<>()) != d.end()) {
    table.refuse("diameters_mm", "diameters_mm out of order; expected ascending diameters");
  }
  if (d.empty() || d.size() != result.factor.size()) {
    table.refuse("factors", fmt::format("{} factors for {} diameters; expected one each, some",
                                        result.factor.size(), d.size()));
  }
  return result;
}

void refuse_wrong_mirrors(const std::string& file, const std::vector<OscillationSet>& sets) {
  for (const OscillationSet& set : sets) {
    const int partner = fold_angles(0, 0, -90, set.index).oscillation;
    const auto other = std::find_if(sets.begin(), sets.end(),
                                    [&](const OscillationSet& s) { return s.index == partner; });
    if (other != sets.end() && mirrors(set, *other)) continue;
    throw std::runtime_error(
        fmt::format("{}: set {}: its left-right mirror image is not set {}; expected there the "
                    "same modes and phi_drop_deg = {}",
                    file, set.index, partner, 0.0 - set.phi_drop_deg));
  }
}

}  // namespace pluvia
