// The streak atlas on the GPU: by far the most that a frame of rain needs (0.5 GB for an atlas of
// 32 columns), so that a renderer made anew for an edited scene takes over what is there.
#pragma once

#include <cstddef>
#include <memory>

#include "atlas/streak_atlas.h"
#include "realtime/cumulative_atlas.h"
#include "realtime/gl_objects.h"

namespace pluvia {

struct GpuAtlas {
  LevelRange levels = {};
  bool environment = false;  // the environment's cells are there
  GlTexture sums = {};       // R32F, one long array folded into layers
  GlBuffer spans = {};
  std::size_t sums_bytes = 0;
};

constexpr int sums_width = 4096, sums_height = 1024;  // a layer of sums: 16 MB

// kept where it has all that is asked for (nullptr: nothing is kept), else a new one. kept must be
// of the same atlas. Throws as cumulative_atlas does.
std::shared_ptr<const GpuAtlas> upload_atlas(const StreakAtlas& atlas, const LevelRange& levels,
                                             bool environment,
                                             std::shared_ptr<const GpuAtlas> kept);

}  // namespace pluvia
