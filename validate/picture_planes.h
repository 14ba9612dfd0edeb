// Pictures as planes of doubles, and filters along rows, then columns: what the picture metrics
// share (validate/flip.h, ssim.h, rain_statistics.h).
#pragma once

#include <Eigen/Core>

#include "atlas/image.h"

namespace pluvia {

// Row y, column x; row 0 at the top.
using Plane = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Kernel = Eigen::ArrayXd;  // odd size, its centre in the middle

// One channel times a factor.
Plane plane_of(const Image& image, int channel, double factor = 1);

// Rec.709 luminance of three channels; one channel is luminance already.
// Throws std::runtime_error for another number of channels.
Plane luminance_of(const Image& image);

// One channel of floats.
Image image_of(const Plane& plane);

// -radius .. radius.
Kernel offsets(int radius);

// exp(-x^2 / (2 sigma^2)) at the offsets: 1 in the middle.
Kernel gaussian(int radius, double sigma_px);

Kernel unit_sum(const Kernel& kernel);

// sum over k, l of across[k] down[l] plane(y + l, x + k); beyond the border the picture continues
// with its border pixels.
Plane filtered(const Plane& plane, const Kernel& across, const Kernel& down);

// Throws std::runtime_error "WHO: .." unless both have one size > 0, all their values, and finite
// ones.
void require_pair(const char* who, const Image& a, const Image& b);

}  // namespace pluvia
