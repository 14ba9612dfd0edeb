#include "realtime/gpu_atlas.h"

#include <algorithm>

namespace pluvia {
namespace {

// Harmonics are laid out by their number; a uniform sky's cell has its place also where there is
// none.
bool holds_sky(int kept_cells, int cells) {
  return kept_cells == cells || (kept_cells == 1 && cells == 0);
}

// The greatest value of the pictures under a point light; 1e-30 for an atlas that is black, or has
// none.
double brightest_per_lux(const StreakAtlas& atlas) {
  float brightest = 1e-30F;
  for (const AtlasLayer& layer : atlas.layers) {
    if (layer.point.empty()) continue;
    for (const float value : layer.point.front().values) brightest = std::max(brightest, value);
  }
  return static_cast<double>(brightest);
}

}  // namespace

std::shared_ptr<const GpuSums> upload_sums(const StreakAtlas& atlas, const LevelRange& levels,
                                           int sky_cells, std::shared_ptr<const GpuSums> kept) {
  if (kept && kept->levels.finest <= levels.finest && kept->levels.coarsest >= levels.coarsest &&
      kept->lights == atlas.lights.size() && holds_sky(kept->sky_cells, sky_cells))
    return kept;
  CumulativeAtlas cumulative = cumulative_atlas(atlas, levels, sky_cells);
  auto made = std::make_shared<GpuSums>();
  made->levels = levels;
  made->lights = atlas.lights.size();
  made->sky_cells = sky_cells;
  made->sums = make_folded_array(GL_R32F, GL_RED, 1, sums_width, sums_height, cumulative.sums);
  made->bytes = (cumulative.sums.size() + cumulative.sky_sums.size()) * sizeof(float);
  made->spans = make_buffer(cumulative.spans);
  if (sky_cells > 1) {
    made->sky_sums =
        make_folded_array(GL_RGBA32F, GL_RGBA, 4, sums_width, sums_height, cumulative.sky_sums);
    made->sky_spans = make_buffer(cumulative.sky_spans);
  }
  return made;
}

std::shared_ptr<const GpuProfiles> upload_profiles(const StreakAtlas& atlas, int first,
                                                   int sky_cells,
                                                   std::shared_ptr<const GpuProfiles> kept) {
  if (kept && kept->first == first && kept->lights == atlas.lights.size() &&
      holds_sky(kept->sky_cells, sky_cells))
    return kept;
  StreakProfiles profiles = streak_profiles(atlas, first, sky_cells);
  auto made = std::make_shared<GpuProfiles>();
  made->first = profiles.first;
  made->levels = profiles.levels;
  made->lights = atlas.lights.size();
  made->brightest_per_lux = brightest_per_lux(atlas);
  made->sky_cells = sky_cells;
  made->profiles =
      make_folded_array(GL_RGBA32F, GL_RGBA, 4, sums_width, sums_height, profiles.values);
  made->spans = make_buffer(profiles.spans);
  return made;
}

}  // namespace pluvia
