// The streak atlas on the GPU: by far the most that a frame of rain needs (0.5 GB for an atlas of
// 32 columns), so that a renderer made anew for an edited scene takes over what is there.
#pragma once

#include <cstddef>
#include <memory>

#include "atlas/streak_atlas.h"
#include "realtime/cumulative_atlas.h"
#include "realtime/gl_objects.h"
#include "realtime/streak_profiles.h"

namespace pluvia {

constexpr int sums_width = 4096, sums_height = 1024;  // a layer of a long array: 4 M texels

struct GpuSums {  // realtime/cumulative_atlas.h
  LevelRange levels = {};
  std::size_t lights = 0;   // cells
  int sky_cells = 0;        // realtime/cumulative_atlas.h
  GlTexture sums = {};      // R32F, one long array folded into layers
  GlTexture sky_sums = {};  // RGBA32F, of harmonics
  GlBuffer sky_spans = {};
  GlBuffer spans = {};
  std::size_t bytes = 0;
};

struct GpuProfiles {  // realtime/streak_profiles.h
  int first = 0, levels = 0;
  std::size_t lights = 0;
  int sky_cells = 0;
  double brightest_per_lux = 0;  // greatest value of the pictures under a point light;
                                 // 1e-30 where they are black, or none
  GlTexture profiles = {};       // RGBA32F, folded alike
  GlBuffer spans = {};
};

struct GpuAtlas {  // what a pass has made of it; nullptr: nothing
  std::shared_ptr<const GpuSums> sums = {};
  std::shared_ptr<const GpuProfiles> profiles = {};
};

// What is kept where it has all that is asked for (nullptr: nothing is kept), else a new one. kept
// must be of the same atlas, or of its coverage alone (realtime/rain_look.h). Throw as
// cumulative_atlas and streak_profiles do.
std::shared_ptr<const GpuSums> upload_sums(const StreakAtlas& atlas, const LevelRange& levels,
                                           int sky_cells, std::shared_ptr<const GpuSums> kept);
std::shared_ptr<const GpuProfiles> upload_profiles(const StreakAtlas& atlas, int first,
                                                   int sky_cells,
                                                   std::shared_ptr<const GpuProfiles> kept);

}  // namespace pluvia
