#include "atlas/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "atlas/oiio_message.h"
#include "atlas/rec709.h"

namespace pluvia {
namespace {

constexpr const char* png_name = "memory.png";

[[noreturn]] void throw_unreadable(const std::string& file, const std::string& why) {
  throw std::runtime_error(
      fmt::format("{}: cannot be read: {}; expected a whole picture", file, one_line(why)));
}

// The first value that `is_bad`, as "FILE: pixel (x, y) channel c ..".
template <typename Predicate, typename Describe>
void refuse_values(const std::string& file, const Image& image, Predicate is_bad,
                   Describe describe) {
  const auto bad = std::find_if(image.values.begin(), image.values.end(), is_bad);
  if (bad == image.values.end()) return;
  const auto index = bad - image.values.begin();
  const auto pixel = index / image.channels;
  throw std::runtime_error(fmt::format("{}: pixel ({}, {}) channel {} {}", file,
                                       pixel % image.width, pixel / image.width,
                                       index % image.channels, describe(*bad)));
}

void refuse_non_finite(const std::string& file, const Image& image) {
  refuse_values(
      file, image, [](float value) { return !std::isfinite(value); },
      [](float value) { return fmt::format("is {}; expected finite values", value); });
}

void check_shape(const std::string& file, const Image& image, std::initializer_list<int> channels) {
  const bool known = std::find(channels.begin(), channels.end(), image.channels) != channels.end();
  const bool sized = image.width > 0 && image.height > 0 &&
                     image.values.size() == static_cast<std::size_t>(image.width) *
                                                static_cast<std::size_t>(image.height) *
                                                static_cast<std::size_t>(image.channels);
  if (known && sized) return;
  throw std::runtime_error(
      fmt::format("{}: a picture of {} x {} pixels, {} channels, {} values; expected {} channels "
                  "and a value for each",
                  file, image.width, image.height, image.channels, image.values.size(),
                  fmt::join(channels, " or ")));
}

std::vector<unsigned char> encode_srgb(const std::string& file,
                                       const std::vector<unsigned char>& shown, int width,
                                       int height, int channels) {
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  OIIO::Filesystem::IOVecOutput memory;
  const auto output = OIIO::ImageOutput::create(png_name, &memory);
  if (!output || !output->open(png_name, spec) ||
      !output->write_image(OIIO::TypeDesc::UINT8, shown.data()) || !output->close()) {
    throw std::runtime_error(
        fmt::format("{}: cannot write: {}; expected a picture that PNG can hold", file,
                    one_line(output ? output->geterror() : OIIO::geterror())));
  }
  return memory.buffer();
}

std::vector<unsigned char> encode_png(const std::string& file, const Image& image, double white) {
  check_shape(file, image, {1, 3});
  refuse_non_finite(file, image);
  if (!(white > 0) || !std::isfinite(white)) {
    throw std::runtime_error(fmt::format("{}: white = {}; expected a number > 0", file, white));
  }
  std::vector<unsigned char> shown;
  shown.reserve(image.values.size());
  for (const float value : image.values) {
    const double linear = std::clamp(static_cast<double>(value) / white, 0.0, 1.0);
    shown.push_back(static_cast<unsigned char>(std::lround(255 * srgb_encoded(linear))));
  }
  return encode_srgb(file, shown, image.width, image.height, image.channels);
}

void write_bytes(const std::string& file, const std::vector<unsigned char>& bytes) {
  write_file_atomically(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

struct WholeImage {
  Image image = {};
  bool encoded = false;  // of whole numbers, 0 .. 1
};

WholeImage read_whole(const std::string& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) {
    throw std::runtime_error(
        fmt::format("{}: cannot read: {}; expected a picture", file, error.message()));
  }
  if (size == 0) throw_unreadable(file, "it is empty");
  OIIO::ImageSpec config;  // else colours of whole numbers come multiplied by their opacity
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::open(file, &config);
  if (!input) throw_unreadable(file, OIIO::geterror());
  if (input->spec().get_int_attribute("oiio:Movie") != 0)
    throw std::runtime_error(file + ": is a video; expected a picture");
  const OIIO::ImageSpec& spec = input->spec();
  Image image = make_image(spec.width, spec.height, spec.nchannels);
  const bool whole =
      input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data());
  if (!whole || input->has_error()) throw_unreadable(file, input->geterror());
  refuse_non_finite(file, image);
  return {std::move(image), !spec.format.is_floating_point()};
}

}  // namespace

Image read_image(const std::string& file) {
  return read_whole(file).image;
}

Image read_environment_map(const std::string& file) {
  const auto [all, encoded] = read_whole(file);
  if (all.channels < 3 || all.width != 2 * all.height) {
    throw std::runtime_error(
        fmt::format("{}: {} x {} pixels, {} channels; expected width = 2 * height and 3 channels",
                    file, all.width, all.height, all.channels));
  }
  Image map = make_image(all.width, all.height, 3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = all.at(x, y, c);
        map.at(x, y, c) = encoded ? static_cast<float>(srgb_linear(value)) : value;
      }
    }
  }
  refuse_values(
      file, map, [](float value) { return value < 0; },
      [](float value) { return fmt::format("= {}; expected >= 0", value); });
  if (std::all_of(map.values.begin(), map.values.end(), [](float value) { return value == 0; })) {
    throw std::runtime_error(fmt::format("{}: all pixels are 0; expected some light", file));
  }
  return map;
}

std::vector<double> mean_over_sphere(const Image& environment) {
  std::vector<double> mean(static_cast<std::size_t>(environment.channels), 0.0);
  for (int y = 0; y < environment.height; ++y) {
    // A row's share of the sphere: (sin top - sin bottom) / 2, split evenly over its pixels.
    const double top = std::cos(std::numbers::pi * y / environment.height);
    const double bottom = std::cos(std::numbers::pi * (y + 1) / environment.height);
    const double weight = (top - bottom) / 2 / environment.width;
    for (int x = 0; x < environment.width; ++x) {
      for (int c = 0; c < environment.channels; ++c) {
        mean[static_cast<std::size_t>(c)] += weight * environment.at(x, y, c);
      }
    }
  }
  return mean;
}

void write_exr(const std::string& file, const Image& image) {
  check_shape(file, image, {1, 3, 4});
  refuse_non_finite(file, image);
  const std::string names = image.channels == 1 ? "Y" : "RGBA";
  ExrPart part = {.name = "image", .width = image.width, .height = image.height};
  const auto count = image.values.size() / static_cast<std::size_t>(image.channels);
  for (int c = 0; c < image.channels; ++c) {
    ExrChannel channel = {.name = std::string(1, names[static_cast<std::size_t>(c)])};
    channel.values.reserve(count);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) channel.values.push_back(image.at(x, y, c));
    }
    part.channels.push_back(std::move(channel));
  }
  write_file_atomically(file, exr_bytes({part}));
}

void write_png(const std::string& file, const Image& image, double white) {
  write_bytes(file, encode_png(file, image, white));
}

void write_srgb_png(const std::string& file, const std::vector<unsigned char>& srgb, int width,
                    int height) {
  write_bytes(file, encode_srgb(file, srgb, width, height, 3));
}

std::vector<unsigned char> png_bytes(const Image& image, double white) {
  return encode_png("PNG", image, white);
}

}  // namespace pluvia
