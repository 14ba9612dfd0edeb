#include "validate/streak_statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/wasserstein.h"

namespace pluvia {
namespace {

using Vector = Eigen::Vector2d;

constexpr double blur_px = 1, tensor_px = 3;
constexpr int blur_radius = 4, tensor_radius = 9;  // at least 3 sigma
constexpr int reach = blur_radius + tensor_radius;
constexpr double farthest_px = 32;

struct Tensor {
  Plane xx = {}, xy = {}, yy = {};
};

Tensor structure_tensor(const Plane& luminance) {
  const Kernel bell = unit_sum(gaussian(blur_radius, blur_px));
  const Kernel place = offsets(blur_radius);
  // Of a slope of 1 the derivative is 1.
  const Kernel slope = place * bell / (place.square() * bell).sum();
  const Plane x = filtered(luminance, slope, bell), y = filtered(luminance, bell, slope);
  const Kernel around = unit_sum(gaussian(tensor_radius, tensor_px));
  return {filtered(x * x, around, around), filtered(x * y, around, around),
          filtered(y * y, around, around)};
}

// Between pixel centres, linearly; none beyond the outer centres.
std::optional<double> value_at(const Plane& plane, const Vector& point) {
  const double x = std::floor(point.x()), y = std::floor(point.y());
  const auto column = static_cast<Eigen::Index>(x), row = static_cast<Eigen::Index>(y);
  if (column < 0 || row < 0 || column + 1 >= plane.cols() || row + 1 >= plane.rows()) {
    return std::nullopt;
  }
  const double u = point.x() - x, v = point.y() - y;
  return (1 - v) * ((1 - u) * plane(row, column) + u * plane(row, column + 1)) +
         v * ((1 - u) * plane(row + 1, column) + u * plane(row + 1, column + 1));
}

// How far from `top` along `step` the plane first falls to `half`.
std::optional<double> distance_to(const Plane& plane, const Vector& top, const Vector& step,
                                  double half) {
  constexpr double stride_px = 0.25;
  double last = plane(static_cast<Eigen::Index>(top.y()), static_cast<Eigen::Index>(top.x()));
  for (double way = stride_px; way <= farthest_px; way += stride_px) {
    const auto value = value_at(plane, top + way * step);
    if (!value) return std::nullopt;
    if (*value <= half) return way - stride_px * (half - *value) / (last - *value);
    last = *value;
  }
  return std::nullopt;
}

struct Direction {
  Vector across = {1, 0};
  double lean_deg = 0, directed_energy = 0;
};

Direction direction_at(const Tensor& tensor, Eigen::Index y, Eigen::Index x) {
  const double difference = tensor.xx(y, x) - tensor.yy(y, x), mixed = 2 * tensor.xy(y, x);
  const double angle = std::atan2(mixed, difference) / 2;  // of across, from x towards y (down)
  return {{std::cos(angle), std::sin(angle)},
          -angle * 180 / std::numbers::pi,
          std::hypot(difference, mixed)};
}

std::optional<RidgePoint> ridge_point(const Plane& blurred, const Direction& direction, int x,
                                      int y) {
  const double top = blurred(y, x);
  const Vector place(x, y);
  // Flat tops are flat up to the rounding of floats.
  const auto falls = [&](double side) {
    const auto value = value_at(blurred, place + side * direction.across);
    return value && *value <= top * (1 + 1e-6);
  };
  if (!falls(1) || !falls(-1)) return std::nullopt;
  const auto right = distance_to(blurred, place, direction.across, top / 2);
  const auto left = distance_to(blurred, place, -direction.across, top / 2);
  if (!right || !left) return std::nullopt;
  return RidgePoint{x, y, top, *left + *right, direction.lean_deg, direction.directed_energy};
}

using Points = std::vector<RidgePoint>;
using Distance = std::function<std::optional<double>(const Points&, const Points&)>;

SampledDistance sampled(const Distance& distance, const Points& a, const Points& reference) {
  constexpr int tile_px = 64;
  Points black, white;
  for (const RidgePoint& point : reference) {
    const bool odd = (point.x_px / tile_px + point.y_px / tile_px) % 2 != 0;
    (odd ? white : black).push_back(point);
  }
  SampledDistance result;
  if (a.empty() && reference.empty()) result.value = 0;
  if (!a.empty() && !reference.empty()) result.value = distance(a, reference);
  // Halves of n points scatter about each other as sqrt(4 / n), two pictures of n as sqrt(2 / n).
  if (!black.empty() && !white.empty()) {
    if (const auto halves = distance(black, white)) result.sampling = *halves / std::sqrt(2);
  }
  return result;
}

std::vector<WeightedSample> samples(const Points& points,
                                    const std::function<WeightedSample(const RidgePoint&)>& of) {
  std::vector<WeightedSample> result;
  result.reserve(points.size());
  std::transform(points.begin(), points.end(), std::back_inserter(result), of);
  return result;
}

double mean_brightness(const Points& points) {
  double sum = 0;
  for (const RidgePoint& point : points) sum += point.brightness;
  return sum / static_cast<double>(points.size());
}

}  // namespace

StreakStatistics streak_statistics(const Image& rain, double least_brightness) {
  require_pair("streak_statistics", rain, rain);
  if (!(least_brightness > 0)) {
    throw std::runtime_error(
        fmt::format("streak_statistics: least_brightness = {}; expected > 0", least_brightness));
  }
  const Plane luminance = luminance_of(rain);
  StreakStatistics result = {.spectrum = power_spectrum(luminance)};
  const Tensor tensor = structure_tensor(luminance);
  const Kernel bell = unit_sum(gaussian(blur_radius, blur_px));
  const Plane blurred = filtered(luminance, bell, bell);
  double directed = 0, all = 0;
  for (int y = reach; y < rain.height - reach; ++y) {
    for (int x = reach; x < rain.width - reach; ++x) {
      const Direction direction = direction_at(tensor, y, x);
      directed += direction.directed_energy;
      all += tensor.xx(y, x) + tensor.yy(y, x);
      if (blurred(y, x) < least_brightness) continue;
      if (const auto point = ridge_point(blurred, direction, x, y)) result.points.push_back(*point);
    }
  }
  result.coherence = all > 0 ? directed / all : 0;
  return result;
}

StatisticsDistance statistics_distance(const StreakStatistics& a,
                                       const StreakStatistics& reference) {
  const double mean = reference.points.empty() ? 1 : mean_brightness(reference.points);
  const auto brightness = [&](const RidgePoint& p) {
    return WeightedSample{p.brightness / mean, 1};
  };
  const auto width = [](const RidgePoint& p) { return WeightedSample{p.width_px, 1}; };
  const auto lean = [](const RidgePoint& p) {
    return WeightedSample{p.lean_deg, p.directed_energy};
  };
  const auto along_line = [](const auto& of) -> Distance {
    return [of](const Points& p, const Points& q) {
      return wasserstein(samples(p, of), samples(q, of));
    };
  };
  const auto directed = [](const Points& points) {
    return std::any_of(points.begin(), points.end(),
                       [](const RidgePoint& p) { return p.directed_energy > 0; });
  };
  const Distance around = [&](const Points& p, const Points& q) -> std::optional<double> {
    if (!directed(p) || !directed(q)) return std::nullopt;
    return circular_wasserstein(samples(p, lean), samples(q, lean), 180);
  };
  return {sampled(along_line(brightness), a.points, reference.points),
          sampled(along_line(width), a.points, reference.points),
          sampled(around, a.points, reference.points),
          spectral_distance(a.spectrum, reference.spectrum)};
}

}  // namespace pluvia
