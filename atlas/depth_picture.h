// Depth of a picture from disk: of each pixel the distance of what it shows, along the camera's
// axis, in metres; infinite where there is nothing, as in the sky.
#pragma once

#include <string>

#include "atlas/image.h"

namespace pluvia {

// One channel. FILE is
// - floats (EXR): metres; of several channels the first, infinity for the sky;
// - a grey PNG of 16 bits: its numbers times scale_m, 65535 for the sky. scale_m = 0: not given,
//   an error then.
// Throws std::runtime_error "FILE: what was found; what is expected", for a depth that is nan, zero
// or negative with its pixel.
Image read_depth(const std::string& file, double scale_m);

}  // namespace pluvia
