#include "raytrace/spherical_harmonics.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace pluvia {

namespace {

constexpr std::size_t orders = highest_harmonic_degree + 1;

// With p_lm = N_lm P_lm / sin^m theta, a polynomial in z:
//   p_mm = start_m,  p_lm = rise_lm (z p_(l-1)m - fall_lm p_(l-2)m)
struct Recurrence {
  std::array<double, orders> start = {};
  std::array<std::array<double, orders>, orders> rise = {}, fall = {};

  Recurrence() {
    start[0] = 1 / std::sqrt(4 * std::numbers::pi);
    for (std::size_t m = 0; m < orders; ++m) {
      const double order = static_cast<double>(m);
      if (m > 0) start[m] = start[m - 1] * std::sqrt((2 * order + 1) / (2 * order));
      for (std::size_t l = m + 1; l < orders; ++l) {
        const double degree = static_cast<double>(l), before = degree - 1;
        rise[l][m] = std::sqrt((4 * degree * degree - 1) / (degree * degree - order * order));
        fall[l][m] = std::sqrt((before * before - order * order) / (4 * before * before - 1));
      }
    }
  }
};

struct Node {
  double z = 0, weight = 0;
};

// Gauss and Legendre's rule of `count` points on [-1, 1], exact to degree 2 count - 1: Newton's
// steps from near each root of P_count.
std::vector<Node> gauss_rule(unsigned count) {
  std::vector<Node> nodes;
  for (unsigned k = 0; k < count; ++k) {
    double z = std::cos(std::numbers::pi * (k + 0.75) / (count + 0.5)), slope = 0;
    for (int step = 0; step < 10; ++step) {
      slope = count * (z * std::legendre(count, z) - std::legendre(count - 1, z)) / (z * z - 1);
      z -= std::legendre(count, z) / slope;
    }
    nodes.push_back({z, 2 / ((1 - z * z) * slope * slope)});
  }
  return nodes;
}

const std::vector<Node>& nodes_for(int degree) {
  static const auto rules = [] {
    std::array<std::vector<Node>, orders> all;
    for (std::size_t l = 0; l < orders; ++l) all[l] = gauss_rule(static_cast<unsigned>(l) + 1);
    return all;
  }();
  return rules[static_cast<std::size_t>(degree)];
}

}  // namespace

void real_harmonics(int degree, const Eigen::Vector3d& direction, std::span<double> values) {
  assert(degree >= 0 && degree <= highest_harmonic_degree);
  assert(values.size() == harmonic_count(degree));
  static const Recurrence recurrence;
  double cosine = 1, sine = 0;  // sin^m theta times cos, sin of m phi
  for (int m = 0; m <= degree; ++m) {
    const auto order = static_cast<std::size_t>(m);
    const double scale = m == 0 ? 1 : std::numbers::sqrt2;
    double p = recurrence.start[order], before = 0;
    for (int l = m; l <= degree; ++l) {
      if (l > m) {
        const auto n = static_cast<std::size_t>(l);
        const double next =
            recurrence.rise[n][order] * (direction.z() * p - recurrence.fall[n][order] * before);
        before = p;
        p = next;
      }
      values[harmonic_index(l, m)] = scale * p * cosine;
      if (m > 0) values[harmonic_index(l, -m)] = scale * p * sine;
    }
    const double old = cosine;
    cosine = direction.x() * cosine - direction.y() * sine;
    sine = direction.x() * sine + direction.y() * old;
  }
}

std::vector<double> turned_about_z(std::span<const double> coefficients, double angle_rad) {
  std::vector<double> turned(coefficients.begin(), coefficients.end());
  for (int l = 0; harmonic_count(l) <= coefficients.size(); ++l) {
    for (int m = 1; m <= l; ++m) {
      const double c = std::cos(m * angle_rad), s = std::sin(m * angle_rad);
      const std::size_t even = harmonic_index(l, m), odd = harmonic_index(l, -m);
      turned[even] = c * coefficients[even] - s * coefficients[odd];
      turned[odd] = s * coefficients[even] + c * coefficients[odd];
    }
  }
  return turned;
}

Eigen::MatrixXd turning_matrix(int degree, const Eigen::Matrix3d& rotation) {
  const auto count = static_cast<Eigen::Index>(harmonic_count(degree));
  const int steps = 2 * degree + 1;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  std::vector<double> here(harmonic_count(degree)), before(harmonic_count(degree));
  for (const Node& node : nodes_for(degree)) {
    const double across = std::sqrt(1 - node.z * node.z);
    for (int k = 0; k < steps; ++k) {
      const double phi = 2 * std::numbers::pi * k / steps;
      const Eigen::Vector3d d(across * std::cos(phi), across * std::sin(phi), node.z);
      real_harmonics(degree, d, here);
      real_harmonics(degree, rotation.transpose() * d, before);
      sum += node.weight * 2 * std::numbers::pi / steps *
             Eigen::Map<Eigen::VectorXd>(here.data(), count) *
             Eigen::Map<Eigen::RowVectorXd>(before.data(), count);
    }
  }
  return sum;
}

}  // namespace pluvia
