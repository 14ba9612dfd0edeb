#include "oscillation/size_distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "oscillation/fall_speed.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int steps = 7000;  // of the midpoint rule: 1 um; its error is below 1e-6 of each integral
constexpr double step_m = largest_diameter_m / steps;

double middle_m(int i) {
  return (i + 0.5) * step_m;
}

// As published, per m^3 and mm.
double published(const SizeDistribution& rain, double diameter_mm) {
  if (rain.law == SizeLaw::marshall_palmer)
    return 8000 * std::exp(-4.1 * std::pow(rain.rate_mm_h, -0.21) * diameter_mm);
  const double water_g_m3 = 0.062 * std::pow(rain.rate_mm_h, 0.913);
  const double d0_mm = 1.571 * std::pow(water_g_m3, 0.1681);
  return std::pow(diameter_mm / d0_mm, 2.5) * std::exp(-5.588 * diameter_mm / d0_mm);
}

// Turns the published numbers into drops per m^4 that carry the rate.
double scale_of(const SizeDistribution& rain) {
  if (!(rain.rate_mm_h >= 0.01 && rain.rate_mm_h <= 300))
    throw std::invalid_argument("rain rate out of range; expected 0.01 .. 300 mm/h");
  double flux_m_s = 0;
  for (int i = 0; i < steps; ++i) {
    const double d = middle_m(i);
    flux_m_s += pi / 6 * d * d * d * fall_speed_m_s(d) * published(rain, 1e3 * d) * step_m;
  }
  return rain.rate_mm_h * 1e-3 / 3600 / flux_m_s;
}

// Of the published numbers, between two diameters: int N dD and int D^2 N dD, and how a part of a
// step is shared out.
struct Moments {
  double number = 0, square_m2 = 0;
};

Moments step_moments(const SizeDistribution& rain, double from_m, double to_m) {
  const double d = (from_m + to_m) / 2;
  const double number = published(rain, 1e3 * d) * (to_m - from_m);
  return {number, number * d * d};
}

}  // namespace

std::vector<double> drops_per_m4(const SizeDistribution& rain,
                                 const std::vector<double>& diameters_m) {
  const double scale = scale_of(rain);
  std::vector<double> result;
  for (const double d : diameters_m)
    result.push_back(d > 0 && d <= largest_diameter_m ? scale * published(rain, 1e3 * d) : 0);
  return result;
}

std::vector<SizeClass> size_classes(const SizeDistribution& rain, int count, double least_m) {
  if (!(count >= 1 && count <= 16))
    throw std::invalid_argument("number of size classes out of range; expected 1 .. 16");
  if (!(least_m > 0 && least_m < largest_diameter_m))
    throw std::invalid_argument("least diameter out of range; expected more than 0, below 7 mm");
  const double scale = scale_of(rain);
  std::vector<Moments> parts;
  double total = 0;
  for (int i = 0; i < steps; ++i) {
    const double from = std::max(least_m, i * step_m), to = (i + 1) * step_m;
    parts.push_back(to > from ? step_moments(rain, from, to) : Moments());
    total += parts.back().square_m2;
  }
  std::vector<Moments> sums(static_cast<std::size_t>(count));
  double before = 0;
  for (const Moments& part : parts) {
    // By the middle of the step: a class is off by half a step at most, and none is lost.
    const double share = (before + part.square_m2 / 2) / total;
    const auto index = std::min(static_cast<int>(share * count), count - 1);
    sums[static_cast<std::size_t>(index)].number += part.number;
    sums[static_cast<std::size_t>(index)].square_m2 += part.square_m2;
    before += part.square_m2;
  }
  std::vector<SizeClass> classes;
  for (const Moments& sum : sums) {
    const double diameter_m = std::sqrt(sum.square_m2 / sum.number);
    classes.push_back({diameter_m, scale * sum.number, fall_speed_m_s(diameter_m)});
  }
  return classes;
}

double extinction_per_m(const SizeDistribution& rain, double least_m) {
  const double scale = scale_of(rain);
  double square_m2 = 0;
  for (int i = 0; i < steps; ++i) {
    const double from = std::max(least_m, i * step_m), to = (i + 1) * step_m;
    if (to > from) square_m2 += step_moments(rain, from, to).square_m2;
  }
  return pi / 4 * scale * square_m2;
}

}  // namespace pluvia
