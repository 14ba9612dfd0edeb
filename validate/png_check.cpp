#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "atlas/rec709.h"
#include "validate/checks.h"

namespace pluvia {

namespace {

std::vector<unsigned char> decoded(const std::vector<unsigned char>& png, const Image& like) {
  OIIO::Filesystem::IOMemReader memory(png.data(), png.size());
  const auto input = OIIO::ImageInput::open("memory.png", nullptr, &memory);
  if (!input) throw std::runtime_error("PNG: cannot be read; expected the picture of a frame");
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width != like.width || spec.height != like.height || spec.nchannels != like.channels) {
    throw std::runtime_error(fmt::format(
        "PNG: {} x {} pixels, {} channels; expected the frame's {} x {} and {}", spec.width,
        spec.height, spec.nchannels, like.width, like.height, like.channels));
  }
  std::vector<unsigned char> bytes(like.values.size());
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, bytes.data()))
    throw std::runtime_error("PNG: cut short; expected a whole picture");
  return bytes;
}

// How far a linear value lies from what a byte stands for, in steps of a byte: 1/2 is as far as
// rounding goes.
double steps_off(unsigned char byte, double linear) {
  const double middle = srgb_linear(byte / 255.0);
  const double side = linear < middle ? -0.5 : 0.5;
  return 0.5 * (linear - middle) / (srgb_linear((byte + side) / 255) - middle);
}

}  // namespace

void add_png_check(const std::string& prefix, const std::vector<unsigned char>& png,
                   const Image& frame, double white, Report& report) {
  const std::vector<unsigned char> bytes = decoded(png, frame);
  double worst = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const double linear = std::clamp(frame.values[i] / white, 0.0, 1.0);
    worst = std::max(worst, steps_off(bytes[i], linear));
  }
  // The two published constants of the curve's kink differ by 2e-5 of a step.
  report.checks.push_back(deviation(
      prefix + ".png", worst, 0, 0.5 + 1e-4, "steps of a byte",
      "The frame's PNG, read back and made linear once by the inverse of the sRGB curve, against "
      "the frame in radiance, cut to what a screen shows: the largest distance. Rounding makes "
      "half a step. Both are deterministic: no uncertainty."));
}

}  // namespace pluvia
