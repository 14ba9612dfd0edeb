// A frame taken apart, exactly: in every pixel and channel
//   color = (1 - coverage) background + rain
// evaluated in double and rounded to float once; coverage = 1 - exp(-tau). The renderer's own
// picture (realtime/shaders/composite.frag) is the same in float.
#pragma once

#include "atlas/image.h"
#include "realtime/rain_renderer.h"

namespace pluvia {

struct FrameLayers {
  Image background = {};  // RGB, cd/m^2: without streaks and splashes, with all other effects
  Image rain = {};        // RGB, cd/m^2: what streaks and splashes add
  Image coverage = {};    // 1 channel, 0 .. 1: of the background, what they take
  Image color = {};       // RGB, cd/m^2
};

FrameLayers frame_layers(Frame frame);

// 1 where coverage is at least that, else 0.
Image rain_mask(const Image& coverage, double least_coverage);

}  // namespace pluvia
