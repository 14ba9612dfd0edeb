// Pictures on disk, through OpenImageIO. Every function throws std::runtime_error with one line
// "FILE: what was found; what is expected". Writing is atomic (atlas/atomic_file.h).
#pragma once

#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

// Any image OpenImageIO reads, as 32-bit floats, all channels. Refuses a NaN or an infinity and
// names its pixel: "FILE: pixel (x, y) channel c is nan; expected finite values". Refuses truncated
// files.
Image read_image(const std::string& file);

// A lat-long environment map: at least 3 channels (the first three are kept), width = 2 height, not
// all zero, no negative value: "FILE: pixel (x, y) channel c = -3.1; expected >= 0". Whole numbers
// are taken as sRGB-encoded, white is 1; floats as they are. Column 0 is longitude -180 deg:
// direction of pixel centre (x, y) in the world (z up):
//   azimuth = 2 pi ((x + 0.5) / width - 0.5) from +x towards -y (so the map reads left to right
//   when seen from inside), elevation = pi (0.5 - (y + 0.5) / height).
Image read_environment_map(const std::string& file);

// Mean radiance of a lat-long map over the sphere (solid-angle weighted), one value per channel.
std::vector<double> mean_over_sphere(const Image& environment);

// OpenEXR, 32-bit float, ZIP; channel names Y, RGB or RGBA by channel count (1, 3, 4).
void write_exr(const std::string& file, const Image& image);

// 8-bit sRGB PNG of linear values (1 or 3 channels) divided by `white`, rounded; values are cut to
// 0..1 there: a PNG is for looking at, EXR is for measuring. No dithering.
void write_png(const std::string& file, const Image& image, double white = 1.0);

// The same of sRGB bytes as a screen shows them: RGB, top row first, 3 width height of them.
void write_srgb_png(const std::string& file, const std::vector<unsigned char>& srgb, int width,
                    int height);

// The bytes of that PNG, for pages that embed it.
std::vector<unsigned char> png_bytes(const Image& image, double white = 1.0);

}  // namespace pluvia
