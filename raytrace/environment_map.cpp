#include "raytrace/environment_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "raytrace/spherical_harmonics.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;

// Pixels are integrated in pieces of at most this share of a half-turn, each at 2 x 2 Gauss points:
// an integrand of degree l is off by about (l pi / 64)^4 / 4320 of its size, 6e-6 at l = 8.
constexpr int least_pieces = 64;

struct Pixel {
  int x = 0, y = 0;
};

// Beyond a pole the map goes on along the opposite meridian.
Pixel on_sphere(const Image& map, int x, int y) {
  if (y < 0 || y >= map.height) {
    y = y < 0 ? -1 - y : 2 * map.height - 1 - y;
    x += map.width / 2;
  }
  x %= map.width;
  return {x < 0 ? x + map.width : x, y};
}

}  // namespace

Eigen::Vector3d map_direction(const Image& map, double column, double row) {
  const double azimuth = 2 * pi * (column / map.width - 0.5);
  const double elevation = pi * (0.5 - row / map.height);
  return {std::cos(elevation) * std::cos(azimuth), -std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

void look_up(const EnvironmentMap& map, const Eigen::Vector3d& direction,
             std::span<double> radiance) {
  const Image& image = map.radiance;
  assert(radiance.size() == static_cast<std::size_t>(image.channels));
  const Eigen::Vector3d d = map.world_from_drop * direction;
  const double azimuth = std::atan2(-d.y(), d.x());
  const double elevation = std::atan2(d.z(), std::hypot(d.x(), d.y()));
  const double column = image.width * (azimuth / (2 * pi) + 0.5) - 0.5;
  const double row = image.height * (0.5 - elevation / pi) - 0.5;
  const int x = static_cast<int>(std::floor(column)), y = static_cast<int>(std::floor(row));
  const double u = column - x, v = row - y;
  std::fill(radiance.begin(), radiance.end(), 0.0);
  for (int k = 0; k < 4; ++k) {
    const Pixel pixel = on_sphere(image, x + k % 2, y + k / 2);
    const double weight = (k % 2 == 0 ? 1 - u : u) * (k / 2 == 0 ? 1 - v : v);
    for (int c = 0; c < image.channels; ++c) {
      radiance[static_cast<std::size_t>(c)] += weight * image.at(pixel.x, pixel.y, c);
    }
  }
}

std::vector<std::vector<double>> harmonic_coefficients(const EnvironmentMap& map, int degree) {
  const Image& image = map.radiance;
  const std::size_t count = harmonic_count(degree);
  std::vector<std::vector<double>> sums(static_cast<std::size_t>(image.channels),
                                        std::vector<double>(count, 0.0));
  std::vector<double> basis(count), pixel(count);
  const int points = 2 * ((least_pieces + image.height - 1) / image.height);  // a side of a pixel
  const auto gauss = [](int k) { return k / 2 * 2 + 1 + (k % 2 == 0 ? -1 : 1) / std::sqrt(3.0); };
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::fill(pixel.begin(), pixel.end(), 0.0);
      for (int k = 0; k < points * points; ++k) {
        const Eigen::Vector3d world =
            map_direction(image, x + gauss(k % points) / points, y + gauss(k / points) / points);
        real_harmonics(degree, map.world_from_drop.transpose() * world, basis);
        const double weight = std::hypot(world.x(), world.y()) * 2 * pi * pi /
                              (points * points * static_cast<double>(image.width) * image.height);
        for (std::size_t i = 0; i < count; ++i) pixel[i] += weight * basis[i];
      }
      for (int c = 0; c < image.channels; ++c) {
        const double radiance = image.at(x, y, c);
        auto& channel = sums[static_cast<std::size_t>(c)];
        for (std::size_t i = 0; i < count; ++i) channel[i] += radiance * pixel[i];
      }
    }
  }
  return sums;
}

}  // namespace pluvia
