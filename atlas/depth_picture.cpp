#include "atlas/depth_picture.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "atlas/gray_png.h"
#include "atlas/oiio_message.h"

namespace pluvia {
namespace {

constexpr std::uint16_t sky_number = 65535;

[[noreturn]] void refuse(const std::string& file, const std::string& found_and_expected) {
  throw std::runtime_error(file + ": " + found_and_expected);
}

Image read_metres(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || error)
    refuse(file, "cannot read: no such file; expected a picture of depths");
  const auto input = OIIO::ImageInput::open(file);
  if (!input)
    refuse(file, "cannot be read: " + one_line(OIIO::geterror()) + "; expected a depth picture");
  const OIIO::ImageSpec& spec = input->spec();
  if (!spec.format.is_floating_point())
    refuse(file, fmt::format("values of type {}; expected floats in metres, or a PNG of 16 bits",
                             spec.format.c_str()));
  Image depth = make_image(spec.width, spec.height);
  if (!input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, depth.values.data()) ||
      input->has_error())
    refuse(file, "cannot be read: " + one_line(input->geterror()) + "; expected a whole picture");
  return depth;
}

Image read_numbers(const std::string& file, double scale_m) {
  const GrayPicture picture = read_gray_png(file);
  if (scale_m == 0) refuse(file, "a PNG has no metres; expected --depth-scale-m, metres of 1");
  Image depth = make_image(picture.width, picture.height);
  for (std::size_t i = 0; i < picture.values.size(); ++i)
    depth.values[i] = picture.values[i] == sky_number
                          ? std::numeric_limits<float>::infinity()
                          : static_cast<float>(scale_m * picture.values[i]);
  return depth;
}

}  // namespace

Image read_depth(const std::string& file, double scale_m) {
  std::string kind = std::filesystem::path(file).extension();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const bool png = kind == ".png";
  if (!png && scale_m != 0) refuse(file, "has metres of its own; expected no --depth-scale-m");
  Image depth = png ? read_numbers(file, scale_m) : read_metres(file);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      if (!(depth.at(x, y) > 0))
        refuse(file, fmt::format("pixel ({}, {}) has depth {} m; expected more than 0, or infinity "
                                 "for the sky",
                                 x, y, depth.at(x, y)));
    }
  }
  return depth;
}

}  // namespace pluvia
