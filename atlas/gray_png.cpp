#include "atlas/gray_png.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string_view>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <zlib.h>

#include "atlas/atomic_file.h"
#include "atlas/oiio_message.h"

namespace pluvia {
namespace {

constexpr const char* png_name = "memory.png";

[[noreturn]] void throw_unreadable(const std::string& file, const std::string& why) {
  throw std::runtime_error(
      fmt::format("{}: cannot be read: {}; expected a whole PNG picture", file, one_line(why)));
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

// A PNG is a row of chunks: length, name, data, checksum. libpng writes to standard error about
// those that are broken, so that they are found here first.
void check_chunks(const std::string& file, std::string_view bytes) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  if (!bytes.starts_with(signature)) throw_unreadable(file, "it is not a PNG");
  std::string_view rest = bytes.substr(signature.size());
  for (std::string_view name; name != "IEND";) {
    const std::size_t length = rest.size() < 12 ? 0 : big_endian(rest.substr(0, 4));
    if (rest.size() < 12 || rest.size() - 12 < length) {
      throw_unreadable(file, fmt::format("it ends after {} bytes", bytes.size()));
    }
    name = rest.substr(4, 4);
    const auto* const data = reinterpret_cast<const unsigned char*>(rest.data() + 4);
    if (crc32(0, data, static_cast<uInt>(length + 4)) != big_endian(rest.substr(8 + length, 4))) {
      throw_unreadable(file, fmt::format("wrong checksum at byte {}", bytes.size() - rest.size()));
    }
    rest.remove_prefix(12 + length);
  }
}

// Behind the signature: length 13, IHDR, width, height, bits, colour type, three more. A damaged
// one may announce any size; deflate packs at most 1032 to 1.
void check_header(const std::string& file, std::string_view bytes) {
  if (big_endian(bytes.substr(8, 4)) != 13 || bytes.substr(12, 4) != "IHDR") {
    throw_unreadable(file, "it does not begin with a header");
  }
  const int bits = bytes[24], colour_type = bytes[25];
  if (bits != 16 || colour_type != 0) {
    throw std::runtime_error(
        fmt::format("{}: {} bits of colour type {}; expected 16 bits of grey "
                    "(type 0)",
                    file, bits, colour_type));
  }
  const std::uint32_t width = big_endian(bytes.substr(16, 4));
  const std::uint32_t height = big_endian(bytes.substr(20, 4));
  const double size = 2.0 * width * height;
  if (size < 2 || size > 1032.0 * static_cast<double>(bytes.size())) {
    throw_unreadable(file, fmt::format("{} x {} pixels in {} bytes", width, height, bytes.size()));
  }
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
  check_chunks(file, bytes);
  check_header(file, bytes);
  OIIO::Filesystem::IOMemReader memory(bytes.data(), bytes.size());
  const auto input = OIIO::ImageInput::open(png_name, nullptr, &memory);
  if (!input) throw_unreadable(file, OIIO::geterror());
  GrayPicture picture = {.width = input->spec().width, .height = input->spec().height};
  picture.values.resize(static_cast<std::size_t>(picture.width) *
                        static_cast<std::size_t>(picture.height));
  const bool whole = input->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, picture.values.data());
  if (!whole || input->has_error()) throw_unreadable(file, input->geterror());
  return picture;
}

}  // namespace pluvia
