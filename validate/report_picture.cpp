#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include <Imath/half.h>
#include <fmt/format.h>
#include <zlib.h>

#include "validate/report_parts.h"

namespace pluvia {
namespace {

// Halves hold up to 65504: with the largest value in [2^14, 2^15) rounding never overflows.
int exponent_of(const Image& image) {
  float largest = 0;
  for (const float value : image.values) {
    if (std::isfinite(value)) largest = std::fmax(largest, std::abs(value));
  }
  return largest > 0 ? std::ilogb(largest) - 14 : 0;
}

// The bits of one plane, each as the step from its left neighbour, high bytes before low ones:
// neighbours are alike, and zlib finds that only byte by byte.
void append_plane(const Image& image, int channel, int exponent,
                  std::vector<unsigned char>& bytes) {
  const std::size_t begin = bytes.size();
  const auto count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  bytes.resize(begin + 2 * count);
  std::size_t i = begin;
  for (int y = 0; y < image.height; ++y) {
    unsigned before = 0;
    for (int x = 0; x < image.width; ++x, ++i) {
      const half value(std::ldexp(image.at(x, y, channel), -exponent));
      const unsigned step = value.bits() - before;
      before = value.bits();
      bytes[i] = static_cast<unsigned char>(step >> 8);
      bytes[i + count] = static_cast<unsigned char>(step);
    }
  }
}

std::vector<unsigned char> deflated(const std::vector<unsigned char>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<unsigned char> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), bytes.size(), Z_BEST_COMPRESSION) != Z_OK) {
    throw std::runtime_error(fmt::format("zlib: cannot pack {} bytes", bytes.size()));
  }
  packed.resize(size);
  return packed;
}

}  // namespace

std::string base64(const std::vector<unsigned char>& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < count; ++k) {
      triple |= static_cast<std::uint32_t>(bytes[i + k]) << (16 - 8 * k);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? digits[(triple >> (18 - 6 * k)) & 63u] : '=';
    }
  }
  return text;
}

PackedPicture pack_picture(const Image& image) {
  const int exponent = exponent_of(image);
  std::vector<unsigned char> bytes;
  for (int c = 0; c < image.channels; ++c) append_plane(image, c, exponent, bytes);
  return {exponent, deflated(bytes)};
}

}  // namespace pluvia
