// Cubic Bezier nets over the unit square: the polynomial through 4 x 4 nodes, and the convex hull
// that its control points give. A linear function that is negative at all control points is
// negative on the whole patch: that is how cells far from a light are dismissed, exactly.
#pragma once

#include <array>
#include <cstddef>

namespace pluvia {

// Control points, u fastest, of C quantities each.
template <std::size_t C>
using BezierNet = std::array<std::array<double, C>, 16>;

// From the values f of a cubic at 0, 1/3, 2/3, 1 to its control points, in place.
template <std::size_t C>
void to_control_points(std::array<double, C>& f0, std::array<double, C>& f1,
                       std::array<double, C>& f2, const std::array<double, C>& f3) {
  for (std::size_t c = 0; c < C; ++c) {
    const double b1 = (-5 * f0[c] + 18 * f1[c] - 9 * f2[c] + 2 * f3[c]) / 6;
    const double b2 = (2 * f0[c] - 9 * f1[c] + 18 * f2[c] - 5 * f3[c]) / 6;
    f1[c] = b1;
    f2[c] = b2;
  }
}

// The same along both axes of 4 x 4 nodes.
template <std::size_t C>
void to_control_points(BezierNet<C>& net) {
  for (std::size_t k = 0; k < 4; ++k) {
    to_control_points(net[4 * k], net[4 * k + 1], net[4 * k + 2], net[4 * k + 3]);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    to_control_points(net[k], net[k + 4], net[k + 8], net[k + 12]);
  }
}

// Bernstein's polynomials of degree 3 at t.
inline std::array<double, 4> bernstein(double t) {
  const double s = 1 - t;
  return {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
}

// De Casteljau's halving along u (stride 1) or v (stride 4).
template <std::size_t C>
void halve(const BezierNet<C>& net, std::size_t stride, BezierNet<C>& low, BezierNet<C>& high) {
  const std::size_t across = 5 - stride;
  for (std::size_t line = 0; line < 4; ++line) {
    const std::size_t n = line * across;
    for (std::size_t c = 0; c < C; ++c) {
      const double a = net[n][c], b = net[n + stride][c];
      const double d = net[n + 2 * stride][c], e = net[n + 3 * stride][c];
      const double ab = 0.5 * (a + b), bd = 0.5 * (b + d), de = 0.5 * (d + e);
      const double abd = 0.5 * (ab + bd), bde = 0.5 * (bd + de);
      low[n][c] = a;
      low[n + stride][c] = ab;
      low[n + 2 * stride][c] = abd;
      low[n + 3 * stride][c] = high[n][c] = 0.5 * (abd + bde);
      high[n + stride][c] = bde;
      high[n + 2 * stride][c] = de;
      high[n + 3 * stride][c] = e;
    }
  }
}

}  // namespace pluvia
