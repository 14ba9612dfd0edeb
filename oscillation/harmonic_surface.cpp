#include "oscillation/harmonic_surface.h"

#include <cmath>

namespace pluvia {

namespace {

using Coefficients = std::array<double, max_harmonic_degree + 1>;

// (Re, Im) of (x + iy)^m; zero for m < 0, where it only ever stands behind a factor 0.
Eigen::Vector2d planar_power(double x, double y, int m) {
  if (m < 0) return {0, 0};
  Eigen::Vector2d z = {1, 0};
  for (int k = 0; k < m; ++k) z = {z[0] * x - z[1] * y, z[0] * y + z[1] * x};
  return z;
}

// Value, first and second derivative of a polynomial of `degree`.
Eigen::Vector3d polynomial(const Coefficients& c, int degree, double z) {
  Eigen::Vector3d v = {0, 0, 0};
  for (int k = degree; k >= 0; --k) {
    v[2] = v[2] * z + 2 * v[1];
    v[1] = v[1] * z + v[0];
    v[0] = v[0] * z + c[static_cast<std::size_t>(k)];
  }
  return v;
}

// Three-term recurrence c_{k+1} = (alpha_k z c_k - beta_k c_{k-1}), from 1 and z.
template <typename Alpha, typename Beta>
Coefficients recurrence(int n, Alpha alpha, Beta beta) {
  Coefficients below = {}, here = {};
  below[0] = 1;
  here[1] = 1;
  if (n == 0) return below;
  for (int k = 1; k < n; ++k) {
    Coefficients next = {};
    for (std::size_t j = 0; j < next.size(); ++j) {
      next[j] = (j > 0 ? alpha(k) * here[j - 1] : 0) - beta(k) * below[j];
    }
    below = here;
    here = next;
  }
  return here;
}

}  // namespace

Coefficients legendre_derivative(int n, int m) {
  assert(0 <= m && m <= n && n <= max_harmonic_degree);
  Coefficients c = recurrence(
      n, [](int k) { return (2.0 * k + 1) / (k + 1); }, [](int k) { return k / (k + 1.0); });
  for (int d = 0; d < m; ++d) {
    for (std::size_t j = 0; j + 1 < c.size(); ++j) c[j] = static_cast<double>(j + 1) * c[j + 1];
    c.back() = 0;
  }
  return c;
}

Coefficients chebyshev(int k) {
  assert(0 <= k && k <= max_harmonic_degree);
  return recurrence(
      k, [](int) { return 2.0; }, [](int) { return 1.0; });
}

Eigen::Matrix3d hessian(const HarmonicSurface<double>& surface, const Eigen::Vector3d& u) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  for (int i = 0; i < surface.order_count; ++i) {
    const auto& order = surface.orders[static_cast<std::size_t>(i)];
    const double m = order.m;
    const Eigen::Vector3d a = polynomial(order.a, order.degree, u.z());
    const Eigen::Vector3d b = polynomial(order.b, order.degree, u.z());
    const Eigen::Vector2d p0 = planar_power(u.x(), u.y(), order.m);
    const Eigen::Vector2d p1 = m * planar_power(u.x(), u.y(), order.m - 1);
    const Eigen::Vector2d p2 = m * (m - 1) * planar_power(u.x(), u.y(), order.m - 2);
    const double xx = a[0] * p2[0] + b[0] * p2[1];
    h(0, 0) += xx;
    h(1, 1) -= xx;
    h(0, 1) += b[0] * p2[0] - a[0] * p2[1];
    h(0, 2) += a[1] * p1[0] + b[1] * p1[1];
    h(1, 2) += b[1] * p1[0] - a[1] * p1[1];
    h(2, 2) += a[2] * p0[0] + b[2] * p0[1];
  }
  h(1, 0) = h(0, 1);
  h(2, 0) = h(0, 2);
  h(2, 1) = h(1, 2);
  return h;
}

}  // namespace pluvia
