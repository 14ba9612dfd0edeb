#include "validate/streak_flux.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/rec709.h"
#include "validate/picture_planes.h"

namespace pluvia {
namespace {

double sum_over(const StreakMask& mask, const Plane& plane) {
  double sum = 0;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (mask.touched[static_cast<std::size_t>(y * mask.width + x)]) {
        sum += plane(mask.y0 + y, mask.x0 + x);
      }
    }
  }
  return sum;
}

Plane variance_of_luminance(const Image& variance) {
  if (*std::min_element(variance.values.begin(), variance.values.end()) < 0) {
    throw std::runtime_error("streak_fluxes: a variance is negative; expected >= 0");
  }
  if (variance.channels == 1) return plane_of(variance, 0);
  Plane sum = Plane::Zero(variance.height, variance.width);
  for (int c = 0; c < 3; ++c) {
    const double weight = rec709_luminance[static_cast<std::size_t>(c)];
    sum += plane_of(variance, c, weight * weight);
  }
  return sum;
}

void require_inside(const StreakMask& mask, const Image& image) {
  const auto pixels = static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height);
  if (mask.x0 >= 0 && mask.y0 >= 0 && mask.x0 + mask.width <= image.width &&
      mask.y0 + mask.height <= image.height && mask.touched.size() == pixels) {
    return;
  }
  throw std::runtime_error(fmt::format(
      "streak_fluxes: a mask of {} x {} pixels at ({}, {}), {} values; expected it in {} x {}",
      mask.width, mask.height, mask.x0, mask.y0, mask.touched.size(), image.width, image.height));
}

}  // namespace

StreakMask mask_of(const Footprint& footprint) {
  StreakMask mask = {footprint.x0, footprint.y0, footprint.width, footprint.height};
  mask.touched.reserve(footprint.values.size());
  for (const StreakValue& value : footprint.values) {
    mask.touched.push_back((value.array() != 0).any());
  }
  return mask;
}

std::vector<StreakFlux> streak_fluxes(const Image& rain, const Image& truth,
                                      const std::vector<StreakMask>& masks,
                                      const std::optional<Image>& variance) {
  require_pair("streak_fluxes", rain, truth);
  if (variance) require_pair("streak_fluxes", truth, *variance);
  const Plane of_rain = luminance_of(rain), of_truth = luminance_of(truth);
  const Plane noise =
      variance ? variance_of_luminance(*variance) : Plane::Zero(rain.height, rain.width);
  std::vector<StreakFlux> fluxes;
  for (const StreakMask& mask : masks) {
    require_inside(mask, rain);
    fluxes.push_back(
        {sum_over(mask, of_rain), sum_over(mask, of_truth), std::sqrt(sum_over(mask, noise))});
  }
  return fluxes;
}

FluxError flux_error(const std::vector<StreakFlux>& fluxes) {
  if (fluxes.empty()) throw std::runtime_error("flux_error: no streak; expected at least one");
  const auto n = static_cast<int>(fluxes.size());
  Image measured = make_image(n, 1), truth = measured, variance = measured, error = measured;
  double squares = 0;
  for (std::size_t i = 0; i < fluxes.size(); ++i) {
    const StreakFlux& flux = fluxes[i];
    measured.values[i] = static_cast<float>(flux.measured);
    truth.values[i] = static_cast<float>(flux.truth);
    variance.values[i] = static_cast<float>(flux.standard_error * flux.standard_error);
    squares += flux.truth * flux.truth / n;
  }
  FluxError result = {.all = noisy_error(measured, truth, variance)};
  if (squares == 0) return result;
  for (std::size_t i = 0; i < fluxes.size(); ++i) {
    error.values[i] =
        static_cast<float>(std::abs(fluxes[i].measured - fluxes[i].truth) / std::sqrt(squares));
  }
  result.of_typical = summary_of(error);
  return result;
}

}  // namespace pluvia
