// Frames of a clip from disk, linear: a video that OpenImageIO's ffmpeg reads, or pictures.
#pragma once

#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

// The first most_frames >= 1 frames, or all where there are fewer, of
// - a video;
// - a folder of pictures, all of one kind, in the order of their names;
// - a pattern FOLDER/NAME in whose NAME a * stands for any letters, as frames/*.png.
// Whole numbers are taken as sRGB-encoded, 0 .. 1, floats as linear. One or three channels; a
// channel of opacity is left out. Throws std::runtime_error "FILE: what was found; what is
// expected" also for values that are not finite or below 0 and frames that differ in size.
std::vector<Image> read_clip(const std::string& source, int most_frames);

}  // namespace pluvia
