#include "raytrace/density_map.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <tiny_gltf.h>

namespace pluvia {
namespace {

constexpr double most_texels = 1 << 26;

// The value of a channel, 0 .. 1.
double channel(const tinygltf::Image& image, std::size_t i) {
  if (image.bits == 8) return image.image[i] / 255.0;
  return (image.image[2 * i] + 256 * image.image[2 * i + 1]) / 65535.0;
}

Eigen::Vector2d texel_m(const DensityMap& map) {
  return (map.max_m - map.min_m).cwiseQuotient(Eigen::Vector2d(map.width, map.height));
}

}  // namespace

DensityMap read_density_map(const std::string& file, const Eigen::Vector2d& min_m,
                            const Eigen::Vector2d& max_m, double height_m) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file + ": cannot be read; expected a grey picture");
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  tinygltf::Image image;
  std::string error, warning;
  const bool read = !bytes.empty() && bytes.size() < (1u << 31) &&
                    tinygltf::LoadImageData(&image, 0, &error, &warning, 0, 0,
                                            reinterpret_cast<const unsigned char*>(bytes.data()),
                                            static_cast<int>(bytes.size()), nullptr);
  if (!read)
    throw std::runtime_error(file + ": is no picture that can be read; expected a grey one");
  if (static_cast<double>(image.width) * image.height > most_texels)
    throw std::runtime_error(fmt::format("{}: {} x {} pixels; expected at most {:.0f} in all", file,
                                         image.width, image.height, most_texels));
  DensityMap map = {.width = image.width,
                    .height = image.height,
                    .min_m = min_m,
                    .max_m = max_m,
                    .height_m = height_m};
  // Grey, grey and alpha, RGB, RGBA.
  const auto channels = static_cast<std::size_t>(image.component);
  const std::size_t colours = channels < 3 ? 1 : 3;
  const auto texels = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  for (std::size_t i = 0; i < texels; ++i) {
    const double value = channel(image, i * channels);
    for (std::size_t c = 1; c < colours; ++c) {
      if (channel(image, i * channels + c) != value)
        throw std::runtime_error(fmt::format(
            "{}: pixel ({}, {}) is coloured; expected a grey picture", file,
            i % static_cast<std::size_t>(map.width), i / static_cast<std::size_t>(map.width)));
    }
    map.share.push_back(static_cast<float>(value));
  }
  sum_density(map);
  return map;
}

void sum_density(DensityMap& map) {
  const auto width = static_cast<std::size_t>(map.width) + 1;
  map.sums.assign(width * (static_cast<std::size_t>(map.height) + 1), 0);
  for (std::size_t y = 1; y <= static_cast<std::size_t>(map.height); ++y) {
    double row = 0;
    for (std::size_t x = 1; x < width; ++x) {
      row += static_cast<double>(map.share[(y - 1) * (width - 1) + x - 1]);
      map.sums[y * width + x] = map.sums[(y - 1) * width + x] + row;
    }
  }
}

double mean_density(const DensityMap& map) {
  return map.share.empty() ? 1 : map.sums.back() / (static_cast<double>(map.width) * map.height);
}

Eigen::Vector2d density_texel(const DensityMap& map, const Eigen::Vector2d& place_m) {
  const Eigen::Vector2d texel = texel_m(map);
  return {(place_m.x() - map.min_m.x()) / texel.x(), (map.max_m.y() - place_m.y()) / texel.y()};
}

double density_of_texel(const DensityMap& map, const Eigen::Vector2d& at) {
  const Eigen::Vector2d texel = at.array().floor();
  if (!(texel.x() >= 0 && texel.x() < map.width && texel.y() >= 0 && texel.y() < map.height))
    return 0;
  return static_cast<double>(
      map.share[static_cast<std::size_t>(texel.y()) * static_cast<std::size_t>(map.width) +
                static_cast<std::size_t>(texel.x())]);
}

namespace {

struct TexelRange {  // x0 .. x1 - 1, y0 .. y1 - 1
  std::size_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

TexelRange touched(const DensityMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  // A texel beside those that rounding could miss would only be looked at in vain.
  const auto index = [](double at, int count) {
    return static_cast<std::size_t>(std::clamp<double>(at, 0, count));
  };
  return {.x0 = index(std::floor(low.x()), map.width),
          .y0 = index(std::floor(low.y()), map.height),
          .x1 = index(std::floor(high.x()) + 1, map.width),
          .y1 = index(std::floor(high.y()) + 1, map.height)};
}

}  // namespace

double density_sum(const DensityMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const TexelRange range = touched(map, low, high);
  if (range.empty()) return 0;
  const auto width = static_cast<std::size_t>(map.width) + 1;
  const auto sum = [&](std::size_t x, std::size_t y) { return map.sums[y * width + x]; };
  // A white texel is 1, the faintest 1.5e-5; sums of 6e7 of them err by 1e-8.
  const double share = sum(range.x1, range.y1) - sum(range.x0, range.y1) - sum(range.x1, range.y0) +
                       sum(range.x0, range.y0);
  return share < 1e-6 ? 0 : share;
}

double density_mean(const DensityMap& map, const Eigen::Vector2d& low,
                    const Eigen::Vector2d& high) {
  const TexelRange range = touched(map, low, high);
  if (range.empty()) return 0;
  return density_sum(map, low, high) /
         static_cast<double>((range.x1 - range.x0) * (range.y1 - range.y0));
}

}  // namespace pluvia
