#include "realtime/gpu_atlas.h"

#include <utility>
#include <vector>

namespace pluvia {
namespace {

bool serves(const GpuAtlas& kept, const LevelRange& levels, bool environment) {
  return kept.levels.finest <= levels.finest && kept.levels.coarsest >= levels.coarsest &&
         (kept.environment || !environment);
}

}  // namespace

std::shared_ptr<const GpuAtlas> upload_atlas(const StreakAtlas& atlas, const LevelRange& levels,
                                             bool environment,
                                             std::shared_ptr<const GpuAtlas> kept) {
  if (kept && serves(*kept, levels, environment)) return kept;
  CumulativeAtlas cumulative = cumulative_atlas(atlas, levels, environment);
  auto made = std::make_shared<GpuAtlas>();
  made->levels = levels;
  made->environment = environment;
  made->sums = make_folded_array(GL_R32F, GL_RED, 1, sums_width, sums_height, cumulative.sums);
  made->sums_bytes = cumulative.sums.size() * sizeof(float);
  made->spans = make_buffer(cumulative.spans);
  return made;
}

}  // namespace pluvia
