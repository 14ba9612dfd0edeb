// 16-bit grey PNG pictures: raw numbers, no colour space, through OpenImageIO.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pluvia {

struct GrayPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> values = {};  // width * height, row by row from the top
};

// The bytes are a function of the picture alone. Throws std::runtime_error for a picture without
// pixels.
std::string gray_png_bytes(const GrayPicture& picture);

// Throws std::runtime_error "FILE: what was found; expected .." for anything but a whole PNG of one
// channel of 16 bits.
GrayPicture read_gray_png(const std::string& file);

}  // namespace pluvia
