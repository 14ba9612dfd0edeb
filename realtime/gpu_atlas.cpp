#include "realtime/gpu_atlas.h"

namespace pluvia {

std::shared_ptr<const GpuSums> upload_sums(const StreakAtlas& atlas, const LevelRange& levels,
                                           bool environment, std::shared_ptr<const GpuSums> kept) {
  if (kept && kept->levels.finest <= levels.finest && kept->levels.coarsest >= levels.coarsest &&
      (kept->environment || !environment))
    return kept;
  CumulativeAtlas cumulative = cumulative_atlas(atlas, levels, environment);
  auto made = std::make_shared<GpuSums>();
  made->levels = levels;
  made->environment = environment;
  made->sums = make_folded_array(GL_R32F, GL_RED, 1, sums_width, sums_height, cumulative.sums);
  made->bytes = cumulative.sums.size() * sizeof(float);
  made->spans = make_buffer(cumulative.spans);
  return made;
}

std::shared_ptr<const GpuProfiles> upload_profiles(const StreakAtlas& atlas, int first,
                                                   bool environment,
                                                   std::shared_ptr<const GpuProfiles> kept) {
  if (kept && kept->first == first && (kept->environment || !environment)) return kept;
  StreakProfiles profiles = streak_profiles(atlas, first, environment);
  auto made = std::make_shared<GpuProfiles>();
  made->first = profiles.first;
  made->levels = profiles.levels;
  made->environment = environment;
  made->profiles =
      make_folded_array(GL_RGBA32F, GL_RGBA, 4, sums_width, sums_height, profiles.values);
  made->spans = make_buffer(profiles.spans);
  return made;
}

}  // namespace pluvia
