#include "validate/streak_features.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pluvia {

namespace {

// Of the path: the fastest mode has two periods in it, each sampled by some 15 points.
constexpr double blur = 1.0 / 60;
constexpr double floor_of_mean = 1e-3;

// Rows' values seen through a Gaussian about `centre`, cut at four standard deviations.
double blurred(const std::vector<double>& rows, double centre, double sigma) {
  const int last = static_cast<int>(rows.size()) - 1;
  const int from = std::clamp(static_cast<int>(std::floor(centre - 4 * sigma)), 0, last);
  const int to = std::clamp(static_cast<int>(std::ceil(centre + 4 * sigma)), 0, last);
  double sum = 0, weights = 0;
  for (int row = from; row <= to; ++row) {
    const double z = (row + 0.5 - centre) / sigma;
    const double weight = std::exp(-0.5 * z * z);
    sum += weight * rows[static_cast<std::size_t>(row)];
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

int feature_points(const StreakFrame& frame) {
  const double sigma = std::max(1.0, blur * frame.path_rows);
  return std::max(2, static_cast<int>(frame.height_px / (2 * sigma)));
}

std::vector<double> streak_features(const StreakFrame& frame, const std::vector<double>& values) {
  const auto width = static_cast<std::size_t>(frame.width_px);
  const auto height = static_cast<std::size_t>(frame.height_px);
  assert(values.size() == width * height);
  std::vector<double> flux(height, 0.0), moment(height, 0.0);
  double mean = 0;
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t column = 0; column < width; ++column) {
      const double value = values[row * width + column];
      const double x = (static_cast<double>(column) + 0.5 - frame.centre_column) / frame.width_px;
      flux[row] += value;
      moment[row] += x * value;
    }
    mean += flux[row] / frame.height_px;
  }
  const double sigma = std::max(1.0, blur * frame.path_rows);
  const int points = feature_points(frame);
  std::vector<double> features(2 * static_cast<std::size_t>(points));
  for (int k = 0; k < points; ++k) {
    const double centre = (k + 0.5) * frame.height_px / points;
    const double root = std::sqrt(blurred(flux, centre, sigma) + floor_of_mean * mean);
    features[static_cast<std::size_t>(k)] = root;
    features[static_cast<std::size_t>(points + k)] =
        root > 0 ? blurred(moment, centre, sigma) / root : 0;
  }
  return features;
}

}  // namespace pluvia
