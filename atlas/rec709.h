// Colours as the project's pictures hold them, linear with Rec.709 primaries, and as a screen wants
// them.
#pragma once

#include <array>
#include <cmath>

namespace pluvia {

// Of linear red, green, blue.
constexpr std::array<double, 3> rec709_luminance = {0.2126, 0.7152, 0.0722};

// The transfer curve of IEC 61966-2-1 (sRGB): 0 .. 1 to 0 .. 1.
inline double srgb_encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// Its inverse.
inline double srgb_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace pluvia
