// One pass of the reference tracer: samples of surfaces pixel by pixel, and of drops stratum by
// stratum (raytrace/reference_picture.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "raytrace/reference_scene.h"
#include "raytrace/reference_strata.h"

namespace pluvia {

struct PassKey {  // decides all random numbers
  std::uint64_t seed = 1;
  std::uint64_t pass = 0;
};

// Samples of what is in a pixel without drops, on a jittered grid of side x side.
struct PixelSample {
  Eigen::Vector3d mean = {0, 0, 0};  // cd/m^2
  double luminance = 0;              // of the mean
  double spread = 0;                 // variance of the samples, weighted as luminance, (cd/m^2)^2
};
PixelSample sample_pixel(const ReferenceScene& scene, const PassKey& key, int x, int y, int side);

struct Deposit {  // of one sample of a drop
  std::uint32_t pixel = 0;
  double weight = 0;  // px^2: what it covers of the pixel, as a mean over the exposure
  Eigen::Vector3d change = {0, 0, 0};  // of radiance by the drop, cd/m^2
};

// Samples of some strata, as many as `samples` says. Notes in the strata what they brought, squares
// times the weight of the pixel.
std::vector<Deposit> sample_strata(const ReferenceScene& scene, const PassKey& key,
                                   const std::vector<double>& pixel_weights,
                                   std::span<Stratum> strata, std::span<const int> samples);

}  // namespace pluvia
