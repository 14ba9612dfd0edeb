#include "oscillation/drop_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;

Eigen::Vector3d unit_direction(double theta_rad, double phi_rad) {
  return {std::sin(theta_rad) * std::cos(phi_rad), std::sin(theta_rad) * std::sin(phi_rad),
          std::cos(theta_rad)};
}

// Largest |P_{n,m}| on [-1, 1] to 4 digits, rounded up by 1 %: it only scales a bound.
double search_legendre_maximum(int n, int m) {
  const auto p = legendre_derivative(n, m);
  double largest = 0;
  const int steps = 400;
  for (int i = 0; i <= steps; ++i) {
    const double z = std::cos(pi * i / steps);
    double value = 0;
    for (int k = n - m; k >= 0; --k) value = value * z + p[static_cast<std::size_t>(k)];
    largest = std::max(largest, std::abs(value) * std::pow(1 - z * z, 0.5 * m));
  }
  return 1.01 * largest;
}

double legendre_maximum(int n, int m) {
  constexpr int size = max_harmonic_degree + 1;
  static const auto table = [] {
    std::array<std::array<double, size>, size> t = {};
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j <= i; ++j) {
        t[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = search_legendre_maximum(i, j);
      }
    }
    return t;
  }();
  return table[static_cast<std::size_t>(n)][static_cast<std::size_t>(m)];
}

void add_bound(DropInstant& drop, int degree, double amplitude) {
  drop.bound_h += amplitude;
  drop.bound_slope += degree * amplitude;
  drop.bound_bend += degree * degree * amplitude;
}

void add_equilibrium(DropInstant& drop, const std::vector<double>& c) {
  assert(c.size() <= max_harmonic_degree + 1);
  for (int k = 0; k < static_cast<int>(c.size()); ++k) {
    const double amplitude = c[static_cast<std::size_t>(k)];
    if (amplitude == 0) continue;
    add_harmonic(drop.surface, 0, k, chebyshev(k), amplitude, 0.0);
    add_bound(drop, k, std::abs(amplitude));
  }
}

void add_bounded_mode(DropInstant& drop, const Mode& mode, double displacement,
                      double phi_drop_rad) {
  add_mode(drop.surface, mode.n, mode.m, displacement, phi_drop_rad);
  add_bound(drop, mode.n, std::abs(displacement) * legendre_maximum(mode.n, mode.m));
}

// Highest degree of h as a spherical polynomial.
int degree_of(const HarmonicSurface<double>& surface) {
  int degree = 0;
  for (int i = 0; i < surface.order_count; ++i) {
    const auto& order = surface.orders[static_cast<std::size_t>(i)];
    degree = std::max(degree, order.m + order.degree);
  }
  return degree;
}

struct Quadrature {
  std::vector<double> z = {}, weight = {};
};

// Gauss-Legendre nodes by Newton on the three-term recurrence.
Quadrature gauss_legendre(int count) {
  Quadrature rule;
  for (int i = 0; i < count; ++i) {
    double z = std::cos(pi * (i + 0.75) / (count + 0.5));
    double slope = 1;
    for (int iteration = 0; iteration < 8; ++iteration) {
      double here = z, below = 1;
      for (int k = 1; k < count; ++k) {
        const double next = ((2 * k + 1) * z * here - k * below) / (k + 1);
        below = here;
        here = next;
      }
      slope = count * (z * here - below) / (z * z - 1);
      z -= here / slope;
    }
    rule.z.push_back(z);
    rule.weight.push_back(2 / ((1 - z * z) * slope * slope));
  }
  return rule;
}

// Integral over the sphere of f(u, r(u)); exact when f is a polynomial of at most `degree` in u.
template <typename Result, typename Integrand>
Result integrate(const DropInstant& drop, int degree, Result sum, Integrand f) {
  const Quadrature rule = gauss_legendre(std::max(2, degree / 2 + 1));
  const int azimuths = degree + 1;
  for (std::size_t i = 0; i < rule.z.size(); ++i) {
    const double rho = std::sqrt(1 - rule.z[i] * rule.z[i]);
    for (int j = 0; j < azimuths; ++j) {
      const double phi = 2 * pi * j / azimuths;
      const Eigen::Vector3d u = {rho * std::cos(phi), rho * std::sin(phi), rule.z[i]};
      sum += rule.weight[i] * 2 * pi / azimuths * f(u, surface_radius_m(drop, u));
    }
  }
  return sum;
}

struct TangentFrame {
  Eigen::Vector3d e1, e2;
};

TangentFrame tangent_frame(const Eigen::Vector3d& u) {
  const Eigen::Vector3d e1 = u.unitOrthogonal();
  return {e1, u.cross(e1)};
}

// Covariant derivatives of h on the unit sphere in the tangent frame: gradient and Hessian.
struct TangentDerivatives {
  double h = 0;
  Eigen::Vector2d gradient = {0, 0};
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
};

TangentDerivatives tangent_derivatives(const HarmonicSurface<double>& surface,
                                       const Eigen::Vector3d& u, const TangentFrame& frame) {
  const auto value = evaluate(surface, u);
  Eigen::Matrix<double, 3, 2> e;
  e << frame.e1, frame.e2;
  return {value.h, e.transpose() * value.gradient,
          e.transpose() * hessian(surface, u) * e -
              Eigen::Matrix2d::Identity() * value.gradient.dot(u)};
}

// A grid of directions; no direction is farther than grid_gap from the nearest of them.
constexpr int grid_rings = 48;
constexpr double grid_gap = pi / grid_rings / std::numbers::sqrt2;

std::vector<Eigen::Vector3d> direction_grid() {
  std::vector<Eigen::Vector3d> grid = {{0, 0, 1}, {0, 0, -1}};
  for (int i = 1; i < grid_rings; ++i) {
    for (int j = 0; j < 2 * grid_rings; ++j) {
      grid.push_back(unit_direction(pi * i / grid_rings, pi * j / grid_rings));
    }
  }
  return grid;
}

// The directions of the grid among which the nearest to the smallest radius must be: over the gap a
// minimum grows by at most bend gap^2 / 2.
std::vector<Eigen::Vector3d> near_minimum(const DropInstant& drop) {
  static const std::vector<Eigen::Vector3d> grid = direction_grid();
  std::vector<double> h;
  h.reserve(grid.size());
  for (const Eigen::Vector3d& u : grid) h.push_back(evaluate(drop.surface, u).h);
  const double most =
      *std::min_element(h.begin(), h.end()) + 0.5 * drop.bound_bend * grid_gap * grid_gap;
  std::vector<Eigen::Vector3d> near;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    if (h[k] <= most) near.push_back(grid[k]);
  }
  return near;
}

// Newton downhill from u, along the principal directions that bend: along a valley (a rotational
// body's ring) nothing is to be won.
double polished_minimum(const DropInstant& drop, Eigen::Vector3d u) {
  double h = evaluate(drop.surface, u).h;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const TangentFrame frame = tangent_frame(u);
    const auto d = tangent_derivatives(drop.surface, u, frame);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal;
    principal.computeDirect(d.second);
    Eigen::Vector2d step = {0, 0};
    for (int k = 0; k < 2; ++k) {
      const double bend = principal.eigenvalues()[k];
      const Eigen::Vector2d axis = principal.eigenvectors().col(k);
      if (bend > 1e-6 * drop.bound_bend) step -= axis * (axis.dot(d.gradient) / bend);
    }
    if (step.norm() > 0.1) break;
    u = (u + step[0] * frame.e1 + step[1] * frame.e2).normalized();
    const double next = evaluate(drop.surface, u).h;
    if (next >= h) break;
    h = next;
  }
  return h;
}

}  // namespace

double mode_frequency_rad_s(const DropShape& drop, int n) {
  return mode_frequency_rad_s(drop.mean_radius_m, drop.density_kg_m3, drop.surface_tension_n_m, n);
}

DropInstant drop_at(const DropShape& drop, double time_s) {
  DropInstant instant;
  instant.surface.scale = drop.mean_radius_m;
  std::array<double, max_harmonic_degree + 1> one = {};
  one[0] = 1;
  add_harmonic(instant.surface, 0, 0, one, 1.0, 0.0);
  add_equilibrium(instant, drop.equilibrium_cos);
  for (const Mode& mode : drop.modes) {
    const double w = mode_frequency_rad_s(drop, mode.n);
    add_bounded_mode(instant, mode, mode.amplitude * std::sin(w * time_s + mode.phase_rad),
                     drop.phi_drop_rad);
  }
  if (drop.keep_volume) {
    const double full = 4 * pi / 3 * std::pow(drop.mean_radius_m, 3);
    instant.surface.scale *= std::cbrt(full / volume_m3(instant));
  }
  if (drop.keep_centroid) instant.origin_m = -centroid_m(instant);
  return instant;
}

bool is_rigid(const DropShape& drop) {
  return std::all_of(drop.modes.begin(), drop.modes.end(),
                     [](const Mode& mode) { return mode.amplitude == 0; });
}

double surface_radius_m(const DropInstant& drop, const Eigen::Vector3d& direction) {
  return drop.surface.scale * evaluate(drop.surface, direction).h;
}

double surface_radius_m(const DropInstant& drop, double theta_rad, double phi_rad) {
  return surface_radius_m(drop, unit_direction(theta_rad, phi_rad));
}

Eigen::Vector3d surface_normal(const DropInstant& drop, const Eigen::Vector3d& u) {
  // The level sets of |p| - r(p/|p|) have the gradient u - grad_T h / h, grad_T tangential.
  const auto value = evaluate(drop.surface, u);
  const Eigen::Vector3d tangential = value.gradient - value.gradient.dot(u) * u;
  return (u - tangential / value.h).normalized();
}

double gaussian_curvature_1_m2(const DropInstant& drop, const Eigen::Vector3d& u) {
  // Fundamental forms of the radial graph r = scale h over the unit sphere.
  const auto d = tangent_derivatives(drop.surface, u, tangent_frame(u));
  const Eigen::Matrix2d identity = Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d slopes = d.gradient * d.gradient.transpose();
  const Eigen::Matrix2d first = slopes + d.h * d.h * identity;
  const Eigen::Matrix2d second = d.h * d.h * identity + 2 * slopes - d.h * d.second;
  const double w2 = d.h * d.h + d.gradient.squaredNorm();
  return second.determinant() /
         (w2 * first.determinant() * drop.surface.scale * drop.surface.scale);
}

double minimum_radius_m(const DropInstant& drop) {
  if (drop.bound_bend == 0) return surface_radius_m(drop, Eigen::Vector3d(0, 0, 1));
  double smallest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& u : near_minimum(drop)) {
    smallest = std::min(smallest, polished_minimum(drop, u));
  }
  return drop.surface.scale * smallest;
}

double minimum_relative_radius(const DropShape& drop, double duration_s, int steps) {
  const int count = is_rigid(drop) ? 1 : steps;
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    const double time_s = count > 1 ? duration_s * i / (count - 1) : 0;
    smallest = std::min(smallest, minimum_radius_m(drop_at(drop, time_s)) / drop.mean_radius_m);
  }
  return smallest;
}

double volume_m3(const DropInstant& drop) {
  return integrate(drop, 3 * degree_of(drop.surface), 0.0,
                   [](const Eigen::Vector3d&, double r) { return r * r * r / 3; });
}

Eigen::Vector3d centroid_m(const DropInstant& drop) {
  const Eigen::Vector3d moment = integrate(
      drop, 4 * degree_of(drop.surface) + 1, Eigen::Vector3d(0, 0, 0),
      [](const Eigen::Vector3d& u, double r) -> Eigen::Vector3d { return r * r * r * r / 4 * u; });
  return moment / volume_m3(drop);
}

}  // namespace pluvia
