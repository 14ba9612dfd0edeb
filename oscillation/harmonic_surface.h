// The surface of a drop at one instant, as a polynomial in the unit direction u = (x, y, z):
//   r(u) = scale h(u),   h(u) = sum_m [ a_m(z) Re (x + iy)^m + b_m(z) Im (x + iy)^m ]
//
// On the unit sphere P_{n,m}(cos theta) cos m phi = (d^m P_n / dz^m)(z) Re (x + iy)^m: every mode
// of the drop and every term cos(k theta) of its equilibrium shape adds to these few polynomials.
// So the one formula has no singular poles, no trigonometry, and any scalar type T (double, Jet).
// Pure functions, thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <Eigen/Core>

namespace pluvia {

constexpr int max_harmonic_degree = 10;

// Coefficients, lowest power first, of d^m P_n / dz^m, P_n Legendre's polynomial, m <= n <= 10.
std::array<double, max_harmonic_degree + 1> legendre_derivative(int n, int m);

// Coefficients of T_k with T_k(cos theta) = cos(k theta). 0 <= k <= 10.
std::array<double, max_harmonic_degree + 1> chebyshev(int k);

template <typename T>
struct HarmonicSurface {
  struct Order {
    int m = 0;
    int degree = 0;  // of a and b in z
    std::array<T, max_harmonic_degree + 1> a = {};
    std::array<T, max_harmonic_degree + 1> b = {};
  };
  T scale = T(1);
  int order_count = 0;
  std::array<Order, max_harmonic_degree + 1> orders = {};  // ascending m
};

// Adds z-polynomial p times (cosine Re (x + iy)^m + sine Im (x + iy)^m).
template <typename T>
void add_harmonic(HarmonicSurface<T>& surface, int m, int degree,
                  const std::array<double, max_harmonic_degree + 1>& p, const T& cosine,
                  const T& sine) {
  assert(m >= 0 && degree >= 0 && m + degree <= max_harmonic_degree);
  auto* const first = surface.orders.data();
  auto* const end = first + surface.order_count;
  auto* const order = std::find_if(first, end, [m](const auto& o) { return o.m >= m; });
  if (order == end || order->m != m) {
    std::move_backward(order, end, end + 1);
    *order = {};
    order->m = m;
    ++surface.order_count;
  }
  order->degree = std::max(order->degree, degree);
  for (std::size_t k = 0; k <= static_cast<std::size_t>(degree); ++k) {
    order->a[k] += cosine * T(p[k]);
    order->b[k] += sine * T(p[k]);
  }
}

// Adds displacement P_{n,m}(cos theta) cos(m (phi - phi_drop)).
template <typename T>
void add_mode(HarmonicSurface<T>& surface, int n, int m, const T& displacement,
              const T& phi_drop_rad) {
  using std::cos, std::sin;
  const T turn = T(m) * phi_drop_rad;
  add_harmonic(surface, m, n - m, legendre_derivative(n, m), T(displacement * cos(turn)),
               m > 0 ? T(displacement * sin(turn)) : T(0));
}

template <typename T>
struct HarmonicValue {
  T h = T(0);
  Eigen::Matrix<T, 3, 1> gradient = Eigen::Matrix<T, 3, 1>::Zero();  // of the polynomial in x, y, z
};

template <typename T>
HarmonicValue<T> evaluate(const HarmonicSurface<T>& surface, const Eigen::Matrix<T, 3, 1>& u) {
  HarmonicValue<T> value;
  T re(1), im(0), re_below(0), im_below(0);  // (x + iy)^m and (x + iy)^(m-1)
  int power = 0;
  for (int i = 0; i < surface.order_count; ++i) {
    const auto& order = surface.orders[static_cast<std::size_t>(i)];
    for (; power < order.m; ++power) {
      re_below = re;
      im_below = im;
      const T next = re * u.x() - im * u.y();
      im = re * u.y() + im * u.x();
      re = next;
    }
    T a(0), b(0), da(0), db(0);  // Horner, value and derivative in z
    for (int k = order.degree; k >= 0; --k) {
      da = da * u.z() + a;
      db = db * u.z() + b;
      a = a * u.z() + order.a[static_cast<std::size_t>(k)];
      b = b * u.z() + order.b[static_cast<std::size_t>(k)];
    }
    const T m(order.m);
    value.h += a * re + b * im;
    value.gradient.x() += m * (a * re_below + b * im_below);
    value.gradient.y() += m * (b * re_below - a * im_below);
    value.gradient.z() += da * re + db * im;
  }
  return value;
}

// Symmetric matrix of second derivatives in x, y, z.
Eigen::Matrix3d hessian(const HarmonicSurface<double>& surface, const Eigen::Vector3d& u);

}  // namespace pluvia
