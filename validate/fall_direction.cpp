#include "validate/fall_direction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/QR>

#include "validate/power_spectrum.h"

namespace pluvia {
namespace {

constexpr int lines = 360;  // over 180 degrees
constexpr double line_deg = 180.0 / lines;

// Between the four frequencies around (u, v) [cycles per pixel]; the plane goes round at its
// borders, as the spectrum of a picture does.
double power_at(const Plane& power, double u, double v) {
  const Eigen::Index w = power.cols(), h = power.rows();
  const double x = u * static_cast<double>(w), y = v * static_cast<double>(h);
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto at = [&](double column, double row) {
    const auto i = static_cast<Eigen::Index>(column), j = static_cast<Eigen::Index>(row);
    return power(((j % h) + h) % h, ((i % w) + w) % w);
  };
  const double fx = x - x0, fy = y - y0;
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
         fy * ((1 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1));
}

// Waves across streaks that lean by lean_deg.
double line_power(const Plane& power, double lean_deg) {
  const double across = std::cos(lean_deg * std::numbers::pi / 180);
  const double down = -std::sin(lean_deg * std::numbers::pi / 180);
  const double step = 1.0 / static_cast<double>(std::max(power.rows(), power.cols()));
  double sum = 0;
  for (double r = 2.0 / static_cast<double>(std::min(power.rows(), power.cols())); r <= 0.5;
       r += step) {
    sum += power_at(power, r * across, r * down);
  }
  return sum;
}

// Peak of the parabola through 17 logarithms around the strongest, in lines from it; 0 where it
// bends the wrong way or peaks beyond them.
double peak_offset(const std::array<double, lines>& sums, int strongest) {
  constexpr int reach = 8;
  Eigen::Matrix<double, 2 * reach + 1, 3> powers;
  Eigen::Vector<double, 2 * reach + 1> logs;
  for (int i = -reach; i <= reach; ++i) {
    powers.row(i + reach) << 1, i, i * i;
    logs[i + reach] = std::log(sums[static_cast<std::size_t>((strongest + i + lines) % lines)]);
  }
  const Eigen::Vector3d fit = powers.householderQr().solve(logs);
  const double offset = -fit[1] / (2 * fit[2]);
  return logs.allFinite() && fit[2] < 0 && std::abs(offset) <= reach ? offset : 0;
}

}  // namespace

std::optional<double> fall_lean_deg(const std::vector<Image>& pictures) {
  Plane power = Plane::Zero(pictures.front().height, pictures.front().width);
  for (const Image& picture : pictures) power += power_plane(plane_of(picture, 0));
  std::array<double, lines> sums = {};
  double mean = 0;
  for (int i = 0; i < lines; ++i) {
    sums[static_cast<std::size_t>(i)] = line_power(power, i * line_deg - 90);
    mean += sums[static_cast<std::size_t>(i)] / lines;
  }
  const auto strongest = std::max_element(sums.begin(), sums.end());
  if (*strongest <= 2 * mean) return std::nullopt;
  const auto line = static_cast<int>(strongest - sums.begin());
  const double lean = (line + peak_offset(sums, line)) * line_deg - 90;
  return lean >= 90 ? lean - 180 : lean < -90 ? lean + 180 : lean;
}

}  // namespace pluvia
