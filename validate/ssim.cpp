#include "validate/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/picture_planes.h"

namespace pluvia {
namespace {

constexpr int radius = 5;
constexpr double sigma_px = 1.5;
constexpr std::array<double, 5> scale_weights = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
// After four halvings a side must still hold a window.
constexpr int least_for_scales = (2 * radius + 1) << 4;

struct Terms {  // of every pixel
  Plane luminance = {}, structure = {};
};

Terms terms_of(const Plane& a, const Plane& b, double range) {
  const Kernel window = unit_sum(gaussian(radius, sigma_px));
  const auto mean = [&](const Plane& plane) { return filtered(plane, window, window); };
  const Plane mean_a = mean(a), mean_b = mean(b);
  // Summed like this, equal pictures give exactly 1.
  const Plane variances = (mean(a * a) - mean_a * mean_a) + (mean(b * b) - mean_b * mean_b);
  const Plane covariance = mean(a * b) - mean_a * mean_b;
  const double c1 = std::pow(0.01 * range, 2), c2 = std::pow(0.03 * range, 2);
  return {(2 * mean_a * mean_b + c1) / (mean_a * mean_a + mean_b * mean_b + c1),
          (2 * covariance + c2) / (variances + c2)};
}

// The pixels whose window lies inside.
Plane inside(const Plane& plane) {
  return plane.block(radius, radius, plane.rows() - 2 * radius, plane.cols() - 2 * radius);
}

Plane halved(const Plane& plane) {
  return Plane::NullaryExpr(
      plane.rows() / 2, plane.cols() / 2,
      [&](Eigen::Index y, Eigen::Index x) { return plane.block<2, 2>(2 * y, 2 * x).mean(); });
}

double over_scales(Plane a, Plane b, double range) {
  double product = 1;
  for (std::size_t scale = 0; scale < scale_weights.size(); ++scale) {
    if (scale > 0) a = halved(a), b = halved(b);
    const Terms terms = terms_of(a, b, range);
    product *= std::pow(std::max(0.0, inside(terms.structure).mean()), scale_weights[scale]);
    if (scale + 1 == scale_weights.size()) {
      product *= std::pow(std::max(0.0, inside(terms.luminance).mean()), scale_weights[scale]);
    }
  }
  return product;
}

}  // namespace

Ssim ssim(const Image& a, const Image& b, double range) {
  require_pair("ssim", a, b);
  const int least = std::min(a.width, a.height);
  if (least < 2 * radius + 1 || !(range > 0) || !std::isfinite(range)) {
    throw std::runtime_error(
        fmt::format("ssim: {} x {} pixels, range {}; expected at least {} x {} and a range > 0",
                    a.width, a.height, range, 2 * radius + 1, 2 * radius + 1));
  }
  const Plane of_a = luminance_of(a), of_b = luminance_of(b);
  const Terms terms = terms_of(of_a, of_b, range);
  const Plane error = 1 - terms.luminance * terms.structure;
  Ssim result = {.map = image_of(error), .error = summary_of(image_of(inside(error)))};
  result.mean = 1 - result.error.mean;
  if (least >= least_for_scales) result.ms_ssim = over_scales(of_a, of_b, range);
  return result;
}

}  // namespace pluvia
