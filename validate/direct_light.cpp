#include "validate/direct_light.h"

#include <cmath>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/LU>

#include "raytrace/drop_field.h"
#include "raytrace/streak_accuracy.h"
#include "raytrace/streak_geometry.h"
#include "validate/format_prices.h"
#include "validate/streak_prices.h"

namespace pluvia {
namespace {

struct PlacedDrop {
  int oscillation = 0;
  StreakPlacement placed = {};
  double texel_px2 = 0;
};

std::vector<PlacedDrop> placed_drops(const Scene& scene, const StreakAtlas& atlas) {
  const auto drops = drops_with_sets(scene, set_numbers(atlas), 0);
  std::vector<PlacedDrop> result;
  for (const Drop& drop : drops) {
    const auto placed = place_streak(scene, drop, streak_geometry(atlas));
    if (!placed) throw std::runtime_error(fmt::format("drop {} is not in view", drop.id));
    Eigen::Matrix2d texel;
    texel << placed->column_px, placed->row_px;
    result.push_back({drop.oscillation, *placed, std::abs(texel.determinant())});
  }
  return result;
}

int whole_degrees(double angle_deg) {
  const double whole = std::round(angle_deg);
  if (std::abs(angle_deg - whole) > 1e-6)
    throw std::runtime_error(fmt::format("a light at {} degrees; expected whole ones", angle_deg));
  return static_cast<int>(whole);
}

double total(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// of(light) in 1/sr px^2 of the picture, for every light of a drop.
template <typename Of>
std::array<double, 3> light_of(const PlacedDrop& drop, Of of) {
  std::array<double, 3> light = {0, 0, 0};
  for (std::size_t k = 0; k < drop.placed.lights.size(); ++k) {
    const double flux = drop.texel_px2 * of(k);
    for (std::size_t c = 0; c < 3; ++c)
      light[c] += flux * drop.placed.lights[k].irradiance_lux[static_cast<Eigen::Index>(c)];
  }
  return light;
}

double cell_total(const StreakAtlas& atlas, int layer, int view, int light) {
  const AtlasCell found = finest_cell(atlas, layer, light, 0);
  return total(cell_of(atlas, found.picture, view, found.column, 0));
}

}  // namespace

DropLight direct_light(const Scene& scene, const StreakAtlas& atlas, const Preset& preset,
                       int accuracy_level) {
  Preset alike = preset;
  alike.width_px = atlas.cell_width_px;
  DropLight light;
  for (const PlacedDrop& drop : placed_drops(scene, atlas)) {
    std::vector<LightDirection> directions;
    for (const LitStreak& lit : drop.placed.lights)
      directions.push_back(
          {whole_degrees(lit.light_elevation_deg), whole_degrees(lit.light_azimuth_deg)});
    const TracedStreak traced = trace_streak(at_accuracy_level(
        streak_of(alike, drop.oscillation, drop.placed.view_elevation_deg, directions),
        accuracy_level));
    light.push_back(light_of(drop, [&](std::size_t k) { return total(traced.light[k].mean); }));
  }
  return light;
}

DropLight looked_up_light(const Scene& scene, const StreakAtlas& atlas, LookupMode mode) {
  const std::vector<LightRow> rows = light_rows(atlas);
  DropLight light;
  for (const PlacedDrop& drop : placed_drops(scene, atlas)) {
    light.push_back(light_of(drop, [&](std::size_t k) {
      const LitStreak& lit = drop.placed.lights[k];
      const FoldedAngles angles =
          fold_angles(drop.placed.view_elevation_deg, lit.light_elevation_deg,
                      lit.light_azimuth_deg, drop.oscillation, views_below(atlas));
      const CellMix mix = mix_cells(atlas, rows, angles, mode);
      double sum = 0;
      for (std::size_t v = 0; v < 2; ++v) {
        for (const LightTap& tap : mix.lights) {
          const int set =
              tap.mirrored ? mirrored_oscillation(angles.oscillation) : angles.oscillation;
          const double weight = mix.view_weight[v] * tap.weight;
          if (weight > 0) sum += weight * cell_total(atlas, set, mix.view[v], tap.light);
        }
      }
      return sum;
    }));
  }
  return light;
}

}  // namespace pluvia
