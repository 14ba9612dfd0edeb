#include "validate/metrics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "atlas/rec709.h"
#include "validate/picture_planes.h"

namespace pluvia {
namespace {

struct Squares {
  double difference = 0, reference = 0;  // sum (a - b)^2, sum b^2
};

Squares squares_of(const Image& a, const Image& b) {
  Squares squares;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double reference = b.values[i], difference = a.values[i] - reference;
    squares.difference += difference * difference;
    squares.reference += reference * reference;
  }
  return squares;
}

// The sums of the header's estimates.
struct NoiseSums {
  double v = 0, least = 0;  // sum v, sum 2 v^2
  double var_d = 0, var_s = 0, covariance = 0;
};

NoiseSums noise_sums(const Image& a, const Image& b, const Image& variance) {
  NoiseSums sums;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double reference = b.values[i], e = a.values[i] - reference, v = variance.values[i];
    sums.v += v;
    sums.least += 2 * v * v;
    sums.var_d += 4 * e * e * v - 2 * v * v;
    sums.var_s += 4 * reference * reference * v - 2 * v * v;
    sums.covariance += -4 * e * reference * v - 2 * v * v;
  }
  sums.var_d = std::max(sums.var_d, sums.least);
  return sums;
}

void require_white(const char* who, double white) {
  if (white > 0 && std::isfinite(white)) return;
  throw std::runtime_error(fmt::format("{}: white or peak {}; expected a number > 0", who, white));
}

}  // namespace

double relative_rmse(const Image& a, const Image& b) {
  require_pair("relative_rmse", a, b);
  const Squares squares = squares_of(a, b);
  if (squares.difference == 0) return 0;
  if (squares.reference == 0) {
    throw std::runtime_error("relative_rmse: the reference is zero everywhere; expected a signal");
  }
  return std::sqrt(squares.difference / squares.reference);
}

NoisyError noisy_error(const Image& a, const Image& b, const Image& variance) {
  require_pair("noisy_error", a, b);
  require_pair("noisy_error", b, variance);
  if (*std::min_element(variance.values.begin(), variance.values.end()) < 0) {
    throw std::runtime_error("noisy_error: a variance is negative; expected >= 0");
  }
  const Squares squares = squares_of(a, b);
  if (squares.difference == 0 && squares.reference == 0) return {.below_noise = true};
  const NoiseSums sums = noise_sums(a, b, variance);
  const double d = squares.difference - sums.v, s = squares.reference - sums.v;
  if (!(s > 0)) {
    throw std::runtime_error(
        fmt::format("noisy_error: the reference's squares add up to {}, its variances to {}; "
                    "expected more signal than noise",
                    squares.reference, sums.v));
  }
  const double ratio = d / s;
  const double variance_of_ratio =
      (sums.var_d + ratio * ratio * sums.var_s - 2 * ratio * sums.covariance) / (s * s);
  return {.relative_rmse = std::sqrt(squares.difference / squares.reference),
          .squared = ratio,
          .standard_error = std::sqrt(std::max(variance_of_ratio, sums.least / (s * s))),
          .noise = std::sqrt(sums.v / s),
          .below_noise = d <= 2 * std::sqrt(sums.least)};
}

PeakError peak_error(const Image& a, const Image& b, double peak) {
  require_pair("peak_error", a, b);
  require_white("peak_error", peak);
  const double mean = squares_of(a, b).difference / static_cast<double>(a.values.size());
  PeakError error = {.rms_over_peak = std::sqrt(mean) / peak};
  if (error.rms_over_peak > 0) error.psnr_db = -20 * std::log10(error.rms_over_peak);
  return error;
}

Image cut_to_screen(const Image& image, double white) {
  require_white("cut_to_screen", white);
  Image shown = image;
  for (float& value : shown.values) {
    value = static_cast<float>(std::clamp(value / white, 0.0, 1.0));
  }
  return shown;
}

Image srgb_of(const Image& image, double white) {
  Image shown = cut_to_screen(image, white);
  for (float& value : shown.values) value = static_cast<float>(srgb_encoded(value));
  return shown;
}

Image luminance_error(const Image& a, const Image& b) {
  require_pair("luminance_error", a, b);
  return image_of((luminance_of(a) - luminance_of(b)).abs());
}

MapSummary summary_of(const Image& map) {
  require_pair("summary_of", map, map);
  std::vector<float> sorted = map.values;
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const auto percentile = [&](double percent) {
    const auto rank = static_cast<std::size_t>(std::ceil(percent / 100 * n));
    return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]);
  };
  return {.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / n,
          .median = percentile(50),
          .percentile_90 = percentile(90),
          .percentile_99 = percentile(99),
          .largest = sorted.back()};
}

}  // namespace pluvia
