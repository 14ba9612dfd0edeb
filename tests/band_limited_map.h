// Functions of few spherical harmonics, and their lat-long pictures.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "raytrace/environment_map.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {

struct BandLimited {
  int degree = 0;
  std::vector<double> coefficients = {};
  double largest = 0;  // bound on its absolute value
};

inline double value_at(const BandLimited& f, const Eigen::Vector3d& direction) {
  std::vector<double> y(f.coefficients.size());
  real_harmonics(f.degree, direction, y);
  double sum = 0;
  for (std::size_t k = 0; k < y.size(); ++k) sum += f.coefficients[k] * y[k];
  return sum;
}

// Random coefficients, and a constant that keeps it positive: sum over |m| <= l of c_m Y_lm is at
// most sqrt(sum c_m^2 (2 l + 1) / (4 pi)), by the addition theorem.
inline BandLimited band_limited(int degree, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  BandLimited f = {.degree = degree, .coefficients = {0}};
  double swing = 0;
  for (int l = 1; l <= degree; ++l) {
    double squares = 0;
    for (int m = -l; m <= l; ++m) {
      f.coefficients.push_back(normal(random));
      squares += f.coefficients.back() * f.coefficients.back();
    }
    swing += std::sqrt(squares * (2 * l + 1) / (4 * std::numbers::pi));
  }
  f.coefficients[0] = swing * std::sqrt(4 * std::numbers::pi);
  f.largest = 2 * swing;
  return f;
}

// f is a function of the drop frame.
inline Image picture_of(const BandLimited& f, const Eigen::Matrix3d& world_from_drop, int height) {
  Image image = make_image(2 * height, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < 2 * height; ++x) {
      const Eigen::Vector3d world = map_direction(image, x + 0.5, y + 0.5);
      image.at(x, y) = static_cast<float>(value_at(f, world_from_drop.transpose() * world));
    }
  }
  return image;
}

}  // namespace pluvia
