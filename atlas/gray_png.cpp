#include "atlas/gray_png.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "atlas/atomic_file.h"

namespace pluvia {
namespace {

constexpr const char* png_name = "memory.png";

// OpenImageIO's messages may span lines and end with one.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown reason" : text;
}

[[noreturn]] void throw_unreadable(const std::string& file, const std::string& why) {
  throw std::runtime_error(
      fmt::format("{}: cannot be read: {}; expected a whole PNG picture", file, one_line(why)));
}

}  // namespace

std::string gray_png_bytes(const GrayPicture& picture) {
  const auto width = static_cast<std::size_t>(std::max(0, picture.width));
  const auto height = static_cast<std::size_t>(std::max(0, picture.height));
  if (picture.values.empty() || picture.values.size() != width * height) {
    throw std::runtime_error(
        fmt::format("a picture of {} x {} pixels with {} values; expected one "
                    "for each, and at least one",
                    picture.width, picture.height, picture.values.size()));
  }
  const OIIO::ImageSpec spec(picture.width, picture.height, 1, OIIO::TypeDesc::UINT16);
  OIIO::Filesystem::IOVecOutput memory;
  const auto output = OIIO::ImageOutput::create(png_name, &memory);
  if (!output || !output->open(png_name, spec) ||
      !output->write_image(OIIO::TypeDesc::UINT16, picture.values.data()) || !output->close()) {
    throw std::runtime_error(
        fmt::format("{}: cannot write: {}; expected a picture that PNG can hold", png_name,
                    one_line(output ? output->geterror() : OIIO::geterror())));
  }
  const std::vector<unsigned char>& bytes = memory.buffer();
  return {bytes.begin(), bytes.end()};
}

GrayPicture read_gray_png(const std::string& file) {
  std::string bytes = read_file(file);
  if (!bytes.starts_with("\x89PNG\r\n\x1a\n")) throw_unreadable(file, "it is not a PNG");
  OIIO::Filesystem::IOMemReader memory(bytes.data(), bytes.size());
  const auto input = OIIO::ImageInput::open(png_name, nullptr, &memory);
  if (!input) throw_unreadable(file, OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.nchannels != 1 || spec.format != OIIO::TypeDesc::UINT16) {
    throw std::runtime_error(fmt::format("{}: {} channels of {}; expected one of uint16", file,
                                         spec.nchannels, spec.format.c_str()));
  }
  // A damaged header may announce any size; deflate packs at most 1032 to 1.
  const double size = static_cast<double>(spec.width) * spec.height;
  if (2 * size > 1032.0 * static_cast<double>(bytes.size())) {
    throw_unreadable(
        file, fmt::format("{} x {} pixels in {} bytes", spec.width, spec.height, bytes.size()));
  }
  GrayPicture picture = {.width = spec.width, .height = spec.height};
  picture.values.resize(static_cast<std::size_t>(spec.width) *
                        static_cast<std::size_t>(spec.height));
  const bool whole = input->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, picture.values.data());
  if (!whole || input->has_error()) throw_unreadable(file, input->geterror());
  return picture;
}

}  // namespace pluvia
