#include "validate/power_spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

namespace pluvia {
namespace {

using Complex = std::complex<double>;
using ComplexPlane = Eigen::Array<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// sin^2 over n pixels: zero half a pixel beyond either end.
Eigen::ArrayXd hann(Eigen::Index n) {
  return (Eigen::ArrayXd::LinSpaced(n, 0.5, static_cast<double>(n) - 0.5) * std::numbers::pi /
          static_cast<double>(n))
      .sin()
      .square();
}

ComplexPlane transformed(const Plane& plane) {
  Eigen::FFT<double> fft;
  ComplexPlane result(plane.rows(), plane.cols());
  std::vector<Complex> in, out;
  for (Eigen::Index y = 0; y < plane.rows(); ++y) {
    in.assign(plane.row(y).begin(), plane.row(y).end());
    fft.fwd(out, in);
    std::copy(out.begin(), out.end(), result.row(y).begin());
  }
  for (Eigen::Index x = 0; x < plane.cols(); ++x) {
    in.assign(result.col(x).begin(), result.col(x).end());
    fft.fwd(out, in);
    std::copy(out.begin(), out.end(), result.col(x).begin());
  }
  return result;
}

// Cycles per pixel of the i-th of n frequencies, -0.5 .. 0.5.
double frequency(Eigen::Index i, Eigen::Index n) {
  return static_cast<double>(i <= n / 2 ? i : i - n) / static_cast<double>(n);
}

// Crests lie across the wave vector (u, v), y down: they lean by -atan(v / u).
int sector_of(double u, double v) {
  const double lean_deg = -std::atan(v / u) * 180 / std::numbers::pi;
  const auto sector = static_cast<int>(std::floor((lean_deg + 90) * spectrum_sectors / 180));
  return sector % spectrum_sectors;  // +90 degrees is -90
}

template <std::size_t n>
double distance_db(const std::array<double, n>& a, const std::array<double, n>& b, double least) {
  if (least == 0) return 0;  // both black
  double squares = 0, count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (a[i] == 0 && b[i] == 0) continue;  // no frequency
    count += 1;
    squares += std::pow(10 * std::log10(std::max(a[i], least) / std::max(b[i], least)), 2);
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

template <std::size_t n>
void divide(std::array<double, n>& sums, const std::array<double, n>& counts) {
  for (std::size_t i = 0; i < n; ++i) sums[i] = counts[i] > 0 ? sums[i] / counts[i] : 0;
}

}  // namespace

Plane power_plane(const Plane& luminance) {
  constexpr Eigen::Index least = 16;
  if (luminance.rows() < least || luminance.cols() < least) {
    throw std::runtime_error(
        fmt::format("power_spectrum: {} x {} pixels; expected at least {} x {}", luminance.cols(),
                    luminance.rows(), least, least));
  }
  const Plane window =
      hann(luminance.rows()).matrix() * hann(luminance.cols()).matrix().transpose();
  const double mean = (window * luminance).sum() / window.sum();
  return transformed(window * (luminance - mean)).abs2() / window.square().sum();
}

PowerSpectrum power_spectrum(const Plane& luminance) {
  const Plane powers = power_plane(luminance);
  PowerSpectrum spectrum;
  spectrum.rounding = std::pow(std::ldexp(luminance.abs().maxCoeff(), -24), 2) / 3;
  std::array<double, spectrum_rings> ring_counts = {};
  std::array<double, spectrum_sectors> sector_counts = {};
  for (Eigen::Index y = 0; y < powers.rows(); ++y) {
    for (Eigen::Index x = 0; x < powers.cols(); ++x) {
      const double u = frequency(x, powers.cols()), v = frequency(y, powers.rows());
      const auto ring = static_cast<std::size_t>(2 * spectrum_rings * std::hypot(u, v));
      if ((x == 0 && y == 0) || ring >= spectrum_rings) continue;
      const double power = powers(y, x);
      const auto sector = static_cast<std::size_t>(sector_of(u, v));
      spectrum.rings[ring] += power, ring_counts[ring] += 1;
      spectrum.sectors[sector] += power, sector_counts[sector] += 1;
    }
  }
  divide(spectrum.rings, ring_counts);
  divide(spectrum.sectors, sector_counts);
  return spectrum;
}

SpectralDistance spectral_distance(const PowerSpectrum& a, const PowerSpectrum& b) {
  const double least = std::max(a.rounding, b.rounding);
  return {distance_db(a.rings, b.rings, least), distance_db(a.sectors, b.sectors, least)};
}

}  // namespace pluvia
