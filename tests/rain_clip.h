// A clip of slanted rain whose background, mattes and rain colour are known: streaks of soft edges
// over a textured background, I = (1 - a) S + a C, as many as it takes for rain to cover each pixel
// in at least half of the frames.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

struct RainClipSpec {
  int width = 96, height = 96, frames = 20;
  double lean_deg = 14;
  double noise = 0;        // standard deviation of each value, in units of white
  double strongest = 0.6;  // of a single streak's matte
  bool even = false;       // a background without texture
  unsigned seed = 7;
  std::array<double, 3> colour = {0.80, 0.86, 0.92};
};

struct RainClip {
  std::vector<Image> frames = {}, mattes = {};
  Image background = {};
};

// A matte from which on rain covers a pixel: 0.05 (C - S) is 0.01 of white and more here, two steps
// of a picture of 8 bits.
constexpr float least_cover = 0.05f;

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) + 0.5) / 4294967296.0;
}

// Smooth light, a row of windows with sharp edges, a fine texture: 0.05 .. 0.6.
inline Image textured_background(int width, int height, bool even) {
  Image image = make_image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool window = x / 12 % 2 == 0 && y / 16 % 2 == 0;
      const double smooth = 0.2 + 0.08 * std::sin(x / 17.0) + 0.07 * std::cos(y / 23.0 + x / 40.0);
      const double fine = 0.02 * std::sin(2.1 * x) * std::sin(1.7 * y);
      const double grey = even ? 0.25 : smooth + fine + (window ? 0.2 : 0);
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(grey * (1 - 0.1 * c));
    }
  }
  return image;
}

// Lays a streak from its middle over the matte: nearer rain hides what is behind it.
inline void lay_streak(Image& matte, double x_px, double y_px, double lean_deg,
                       const RainClipSpec& spec, std::mt19937& random) {
  const double lean = lean_deg * std::numbers::pi / 180;
  const double half_length = uniform(random, 10, 25), sigma = uniform(random, 0.6, 1.3);
  const double peak = uniform(random, 0.15, spec.strongest);
  for (int y = 0; y < matte.height; ++y) {
    for (int x = 0; x < matte.width; ++x) {
      const double dx = x - x_px, dy = y - y_px;
      const double along = dx * std::sin(lean) + dy * std::cos(lean);
      const double across = dx * std::cos(lean) - dy * std::sin(lean);
      const double end = std::clamp((half_length - std::abs(along)) / 3 + 0.5, 0.0, 1.0);
      const double here = peak * end * std::exp(-across * across / (2 * sigma * sigma));
      float& a = matte.at(x, y);
      a = static_cast<float>(1 - (1 - a) * (1 - here));
    }
  }
}

inline void lay_random_streak(std::vector<Image>& mattes, double x_px, double y_px,
                              const RainClipSpec& spec, std::mt19937& random) {
  Image& matte = mattes[random() % mattes.size()];
  const double lean = spec.lean_deg + uniform(random, -1, 1);
  lay_streak(matte, x_px, y_px, lean, spec, random);
}

inline std::size_t covered_frames(const std::vector<Image>& mattes, std::size_t pixel) {
  return static_cast<std::size_t>(
      std::count_if(mattes.begin(), mattes.end(),
                    [&](const Image& matte) { return matte.values[pixel] >= least_cover; }));
}

// Where rain covers a pixel in fewer than half of the frames, another streak falls there: pixels in
// an order that goes all over the picture.
inline std::vector<Image> covering_mattes(const RainClipSpec& spec, std::mt19937& random) {
  std::vector<Image> mattes(static_cast<std::size_t>(spec.frames),
                            make_image(spec.width, spec.height));
  const int pixels = spec.width * spec.height;
  for (int i = 0; i < pixels; ++i) {
    const int pixel = static_cast<int>(7919LL * i % pixels);  // a prime
    const int x = pixel % spec.width, y = pixel / spec.width;
    while (2 * covered_frames(mattes, static_cast<std::size_t>(pixel)) < mattes.size())
      lay_random_streak(mattes, x, y + uniform(random, -8, 8), spec, random);
  }
  return mattes;
}

inline double gaussian_noise(std::mt19937& random) {
  return std::sqrt(-2 * std::log(uniform(random, 0, 1))) *
         std::cos(2 * std::numbers::pi * uniform(random, 0, 1));
}

inline RainClip rain_clip(const RainClipSpec& spec) {
  std::mt19937 random(spec.seed);
  RainClip clip = {.mattes = covering_mattes(spec, random),
                   .background = textured_background(spec.width, spec.height, spec.even)};
  for (const Image& matte : clip.mattes) {
    Image frame = clip.background;
    for (std::size_t i = 0; i < frame.values.size(); ++i) {
      const double a = matte.values[i / 3];
      const double light = (1 - a) * frame.values[i] + a * spec.colour[i % 3];
      const double noise = spec.noise > 0 ? spec.noise * gaussian_noise(random) : 0;
      frame.values[i] = static_cast<float>(std::max(light + noise, 0.0));
    }
    clip.frames.push_back(frame);
  }
  return clip;
}

}  // namespace pluvia
