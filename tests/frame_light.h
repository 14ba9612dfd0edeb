// The light of a frame's rain, and what of the picture rain covers.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "realtime/rain_renderer.h"

namespace pluvia {

// Pixels: the sum of 1 - exp(-tau).
inline double covered(const Frame& frame) {
  double sum = 0;
  for (const float tau : frame.rain_tau.values) sum -= std::expm1(-static_cast<double>(tau));
  return sum;
}

// Radiance of the rain, summed over pixels.
inline double light(const Frame& frame, int channel) {
  double sum = 0;
  for (std::size_t i = static_cast<std::size_t>(channel); i < frame.rain.values.size(); i += 3)
    sum += static_cast<double>(frame.rain.values[i]);
  return sum;
}

// Mean radiance of what is covered.
inline Eigen::Vector3d brightness(const Frame& frame) {
  return Eigen::Vector3d(light(frame, 0), light(frame, 1), light(frame, 2)) / covered(frame);
}

}  // namespace pluvia
