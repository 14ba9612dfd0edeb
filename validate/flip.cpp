#include "validate/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include "validate/picture_planes.h"

namespace pluvia {
namespace {

using Planes = std::array<Plane, 3>;

// Linear Rec.709 to X, Y, Z in units of white: from the primaries' and D65's chromaticities, x and
// y, as the published constants are (their white is 0.31271, 0.32902).
Eigen::Matrix3d rec709_to_xyz_of_white() {
  const auto xyz = [](double x, double y) { return Eigen::Vector3d(x / y, 1, (1 - x - y) / y); };
  const Eigen::Vector3d white = xyz(0.31271, 0.32902);
  Eigen::Matrix3d primaries;
  primaries << xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06);
  const Eigen::Vector3d share = primaries.inverse() * white;
  return white.cwiseInverse().asDiagonal() * primaries * share.asDiagonal();
}

// L*a*b* (CIE 1976) of X, Y, Z in units of white; a and b times L / 100: Hunt's effect, by which
// colours count less where it is dark.
Eigen::Vector3d hunt_lab(const Eigen::Vector3d& xyz_of_white) {
  constexpr double knee = 6.0 / 29;
  const Eigen::Vector3d f = xyz_of_white.unaryExpr([](double t) {
    return t > knee * knee * knee ? std::cbrt(t) : t / (3 * knee * knee) + 4.0 / 29;
  });
  const double lightness = 116 * f.y() - 16;
  return {lightness, 0.01 * lightness * 500 * (f.x() - f.y()),
          0.01 * lightness * 200 * (f.y() - f.z())};
}

// |dL| + |(da, db)| to the power 0.7 (Abasi et al. 2020; the power is q_c of the paper).
double color_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = a - b;
  return std::pow(std::abs(d.x()) + std::hypot(d.y(), d.z()), 0.7);
}

// To 0 .. 1: `largest`, that of green and blue, is 1, and p_c = 0.4 of it p_t = 0.95.
double redistributed(double distance, double largest) {
  const double bend = 0.4 * largest;
  return distance < bend ? 0.95 * distance / bend
                         : 0.95 + (distance - bend) / (largest - bend) * (1 - 0.95);
}

// Positive weights sum to 1, negative ones to -1.
Kernel unit_halves(const Kernel& kernel) {
  return kernel.max(0) / kernel.max(0).sum() - (-kernel).max(0) / (-kernel).max(0).sum();
}

// The eye's contrast sensitivity as a blur: sum of a sqrt(pi / b) exp(-pi^2 r^2 / b), r in degrees.
struct Sensitivity {
  std::array<double, 2> a = {};
  std::array<double, 2> b_deg2 = {};  // of a = 0: any
};
constexpr std::array<Sensitivity, 3> sensitivities = {
    Sensitivity{{1, 0}, {0.0047, 1}},           // luminance
    Sensitivity{{1, 0}, {0.0053, 1}},           // red-green
    Sensitivity{{34.1, 13.5}, {0.04, 0.025}}};  // blue-yellow

// Each term is a Gaussian, so it is applied along rows, then columns; the sum of all weights of
// both terms over the square of the kernel is 1.
Plane blurred(const Plane& plane, const Sensitivity& eye, double pixels_per_degree) {
  constexpr double widest_deg2 = 0.04;  // one square for all channels: 3 sigma of the widest
  const double degree = pixels_per_degree / std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(widest_deg2 / 2) * degree));
  Plane sum = Plane::Zero(plane.rows(), plane.cols());
  double weight = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    if (eye.a[i] == 0) continue;
    const Kernel one = gaussian(radius, std::sqrt(eye.b_deg2[i] / 2) * degree);
    const double height = eye.a[i] * std::sqrt(std::numbers::pi / eye.b_deg2[i]);
    sum += height * filtered(plane, one, one);
    weight += height * one.sum() * one.sum();
  }
  return sum / weight;
}

// Luminance 0 .. 1 and the two opponent colours, linear. The papers write YCxCz with factors and an
// offset; a blur whose weights sum to 1 commutes with both, so they are left out.
Planes opponents(const Planes& rgb) {
  const Eigen::Matrix3d m = rec709_to_xyz_of_white();
  const auto row = [&](int i) { return m(i, 0) * rgb[0] + m(i, 1) * rgb[1] + m(i, 2) * rgb[2]; };
  const Plane x = row(0), y = row(1), z = row(2);
  return {y, x - y, y - z};
}

// A picture as the metric sees it.
struct Seen {
  Planes lab = {};  // blurred, Hunt-adjusted
  Plane edges = {};
  Plane points = {};
};

Planes blurred_lab(const Planes& opponent, double pixels_per_degree) {
  Planes lab = {};
  for (std::size_t i = 0; i < 3; ++i) {
    lab[i] = blurred(opponent[i], sensitivities[i], pixels_per_degree);
  }
  const Eigen::Matrix3d to_xyz = rec709_to_xyz_of_white(), to_rgb = to_xyz.inverse();
  for (Eigen::Index i = 0; i < lab[0].size(); ++i) {
    const double y = lab[0](i), x = y + lab[1](i), z = y - lab[2](i);
    // Channels are blurred differently, which can leave what a display shows; the paper cuts there.
    const Eigen::Vector3d rgb = (to_rgb * Eigen::Vector3d(x, y, z)).cwiseMax(0).cwiseMin(1);
    const Eigen::Vector3d color = hunt_lab(to_xyz * rgb);
    for (std::size_t c = 0; c < 3; ++c) lab[c](i) = color[static_cast<Eigen::Index>(c)];
  }
  return lab;
}

Seen seen(const Planes& rgb, double pixels_per_degree) {
  const Planes opponent = opponents(rgb);
  // The eye's edge detector is 0.082 degrees wide from peak to trough: two sigma.
  const double sigma_px = 0.5 * 0.082 * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma_px));
  const Kernel bell = gaussian(radius, sigma_px), place = offsets(radius) / sigma_px;
  const Kernel edge = unit_halves(place * bell), point = unit_halves((place.square() - 1) * bell);
  const auto strength = [&](const Kernel& kernel) -> Plane {
    const Kernel across = unit_sum(bell);
    const Plane x = filtered(opponent[0], kernel, across),
                y = filtered(opponent[0], across, kernel);
    return (x.square() + y.square()).sqrt();
  };
  return {blurred_lab(opponent, pixels_per_degree), strength(edge), strength(point)};
}

Plane error_between(const Planes& reference, const Planes& test, double pixels_per_degree) {
  const Seen a = seen(reference, pixels_per_degree), b = seen(test, pixels_per_degree);
  const Eigen::Matrix3d to_xyz = rec709_to_xyz_of_white();
  const double largest = color_distance(hunt_lab(to_xyz.col(1)), hunt_lab(to_xyz.col(2)));
  Plane error(a.edges.rows(), a.edges.cols());
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const auto lab = [i](const Seen& s) {
      return Eigen::Vector3d(s.lab[0](i), s.lab[1](i), s.lab[2](i));
    };
    const double color = redistributed(color_distance(lab(a), lab(b)), largest);
    const double feature =
        std::max(std::abs(a.edges(i) - b.edges(i)), std::abs(a.points(i) - b.points(i)));
    error(i) = std::pow(color, 1 - std::sqrt(feature / std::numbers::sqrt2));
  }
  return error;
}

Planes planes_of(const Image& image, double factor = 1) {
  return {plane_of(image, 0, factor), plane_of(image, 1, factor), plane_of(image, 2, factor)};
}

FlipError pooled(const Plane& error) {
  FlipError result = {.map = image_of(error)};
  std::vector<double> sorted(error.data(), error.data() + error.size());
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> sums(sorted.size());
  std::partial_sum(sorted.begin(), sorted.end(), sums.begin());
  const auto percentile = [&](double p) {
    const auto place = std::lower_bound(sums.begin(), sums.end(), p * sums.back()) - sums.begin();
    return sorted[static_cast<std::size_t>(place)];
  };
  result.mean = sums.back() / static_cast<double>(sums.size());
  result.least = sorted.front();
  result.largest = sorted.back();
  result.weighted_first_quartile = percentile(0.25);
  result.weighted_median = percentile(0.5);
  result.weighted_third_quartile = percentile(0.75);
  return result;
}

void check(const char* who, const Image& a, const Image& b, float most, double pixels_per_degree) {
  if (a.width != b.width || a.height != b.height || a.channels != 3 || b.channels != 3 ||
      a.values.empty() || a.values.size() != b.values.size()) {
    throw std::runtime_error(fmt::format(
        "{}: pictures of {} x {} x {} and {} x {} x {}; expected equal sizes > 0, 3 channels", who,
        a.width, a.height, a.channels, b.width, b.height, b.channels));
  }
  for (const Image* image : {&a, &b}) {
    const auto bad = std::find_if(image->values.begin(), image->values.end(),
                                  [&](float v) { return !(v >= 0 && v <= most); });
    if (bad != image->values.end()) {
      throw std::runtime_error(fmt::format("{}: value {}; expected 0 .. {}", who, *bad, most));
    }
  }
  if (!(pixels_per_degree >= 1 && pixels_per_degree <= 1000)) {
    throw std::runtime_error(
        fmt::format("{}: pixels_per_degree = {}; expected 1 .. 1000", who, pixels_per_degree));
  }
}

// Narkowicz' fit of the ACES curve, with the exposure of 0.6 that it was fitted for, as HDR-FLIP
// uses it: (n2 x^2 + n1 x) / (d2 x^2 + d1 x + d0), cut at 1.
constexpr double n2 = 0.36 * 2.51, n1 = 0.6 * 0.03, d2 = 0.36 * 2.43, d1 = 0.6 * 0.59, d0 = 0.14;

Planes tone_mapped(Planes planes) {
  for (Plane& x : planes) {
    x = ((n2 * x + n1) * x / ((d2 * x + d1) * x + d0)).min(1).eval();
  }
  return planes;
}

// Where the curve is 0.85, t of the paper: the root > 0 of (n2 - t d2) x^2 + (n1 - t d1) x - t d0.
double bright_value() {
  constexpr double t = 0.85, a = n2 - t * d2, b = n1 - t * d1, c = -t * d0;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

// Start and stop of the reference, in stops, where they are not given.
std::pair<double, double> exposures_of(const Image& reference, const HdrFlipOptions& options) {
  Plane y = opponents(planes_of(reference))[0];
  const Eigen::Index half = (y.size() - 1) / 2;
  std::nth_element(y.data(), y.data() + half, y.data() + y.size());
  const auto stops = [](const std::optional<double>& given, const char* of, double luminance) {
    if (given) return *given;
    if (luminance > 0) return std::log2(bright_value() / luminance);
    throw std::runtime_error(fmt::format(
        "hdr_flip: the reference's {} luminance is 0; expected > 0, or given exposures", of));
  };
  const double start = stops(options.start_exposure_stops, "largest", y.maxCoeff());
  const double stop = stops(options.stop_exposure_stops, "median", y(half));
  constexpr double most = 300;  // 2^stops times any float stays finite, and so does its square
  if (start <= stop && start >= -most && stop <= most) return {start, stop};
  throw std::runtime_error(fmt::format(
      "hdr_flip: exposures from {} to {} stops; expected start <= stop within -{} .. {}", start,
      stop, most, most));
}

}  // namespace

FlipError ldr_flip(const Image& reference, const Image& test, const FlipOptions& options) {
  check("ldr_flip", reference, test, 1, options.pixels_per_degree);
  return pooled(error_between(planes_of(reference), planes_of(test), options.pixels_per_degree));
}

HdrFlipError hdr_flip(const Image& reference, const Image& test, const HdrFlipOptions& options) {
  const double pixels_per_degree = options.flip.pixels_per_degree;
  check("hdr_flip", reference, test, std::numeric_limits<float>::max(), pixels_per_degree);
  const auto [start, stop] = exposures_of(reference, options);
  const int exposures = std::max(2, static_cast<int>(std::ceil(stop - start)));
  Plane largest = Plane::Zero(reference.height, reference.width);
  for (int i = 0; i < exposures; ++i) {
    const double factor = std::exp2(start + (stop - start) * i / (exposures - 1));
    const Planes a = tone_mapped(planes_of(reference, factor));
    const Planes b = tone_mapped(planes_of(test, factor));
    largest = largest.max(error_between(a, b, pixels_per_degree));
  }
  return {pooled(largest), start, stop, exposures};
}

}  // namespace pluvia
