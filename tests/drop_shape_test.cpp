#include "oscillation/drop_shape.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"
#include "tests/table_file.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

double sphere_volume(double radius_m) {
  return 4 * pi / 3 * std::pow(radius_m, 3);
}

TEST(DropShape, TheRadiusIsThePublishedSumAtAnyTime) {
  DropShape shape;
  shape.mean_radius_m = 1.6e-3;
  shape.modes = {{2, 0, 0.2, 0.3}, {3, 1, 0.1, 1.1}, {8, 5, 1e-6, 0}};
  shape.phi_drop_rad = 0.7;
  shape.equilibrium_cos = {-0.01, 0.005, -0.05};
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double t = uniform(random, 0, 0.02), theta = uniform(random, 0, pi);
    const double phi = uniform(random, -pi, pi);
    double sum = 1 - 0.01 + 0.005 * std::cos(theta) - 0.05 * std::cos(2 * theta);
    for (const Mode& mode : shape.modes) {
      const double w = mode_frequency_rad_s(shape, mode.n);
      const auto n = static_cast<unsigned>(mode.n), m = static_cast<unsigned>(mode.m);
      sum += mode.amplitude * std::sin(w * t + mode.phase_rad) *
             std::assoc_legendre(n, m, std::cos(theta)) * std::cos(mode.m * (phi - 0.7));
    }
    EXPECT_NEAR(surface_radius_m(drop_at(shape, t), theta, phi), 1.6e-3 * sum, 1e-16);
  }
}

TEST(DropShape, FrequenciesAreRayleighs) {
  // The table has sigma = 0.07275 N/m and three decimals of Hz.
  const auto rows = table_rows("oscillation_modes.csv");
  ASSERT_GT(rows.size(), 5u);
  for (const auto& row : rows) {
    DropShape shape;
    shape.mean_radius_m = std::stod(row[0]) * 0.5e-3;
    shape.surface_tension_n_m = 0.07275;
    for (int n = 2; n <= 5; ++n) {
      const double hz = std::stod(row[static_cast<std::size_t>(n) - 1]);
      EXPECT_NEAR(mode_frequency_rad_s(shape, n) / (2 * pi), hz, 1e-3) << row[0] << " mm, n " << n;
    }
  }
}

TEST(DropShape, AfterAPeriodOfItsOnlyModeTheDropLooksTheSame) {
  DropShape shape;
  shape.modes = {{.n = 3, .m = 2, .amplitude = 0.01, .phase_rad = 0.4}};
  const double period = 2 * pi / mode_frequency_rad_s(shape, 3);
  const DropInstant now = drop_at(shape, 0.001), later = drop_at(shape, 0.001 + period);
  const DropInstant half = drop_at(shape, 0.001 + period / 2);
  const double r = surface_radius_m(now, 1, 0.2);
  EXPECT_NEAR(surface_radius_m(later, 1, 0.2), r, 1e-15);
  EXPECT_NEAR(surface_radius_m(half, 1, 0.2) - 1e-3, 1e-3 - r, 1e-15);  // mirrored about r0
  EXPECT_GT(std::abs(r - 1e-3), 1e-6);
}

TEST(DropShape, OnlyADropWithoutMovingModesIsRigid) {
  DropShape shape;
  EXPECT_TRUE(is_rigid(shape));
  shape.equilibrium_cos = {0, 0, -0.05};
  shape.modes = {{.n = 2, .amplitude = 0}};
  EXPECT_TRUE(is_rigid(shape));
  shape.modes.push_back({.n = 3, .amplitude = 1e-9});
  EXPECT_FALSE(is_rigid(shape));
}

// The table's modes, written like "(2;0)=0.1 (3;1)=0.05".
std::vector<Mode> parse_modes(const std::string& text) {
  std::vector<Mode> modes;
  for (std::size_t at = text.find('('); at != std::string::npos; at = text.find('(', at + 1)) {
    const std::size_t equals = text.find('=', at);
    modes.push_back({.n = text[at + 1] - '0',
                     .m = text[at + 3] - '0',
                     .amplitude = std::stod(text.substr(equals + 1))});
  }
  return modes;
}

TEST(DropShape, VolumeAndCentroidAreTheTables) {
  const auto rows = table_rows("mode_volume_com.csv");
  ASSERT_EQ(rows.size(), 11u);
  for (const auto& row : rows) {
    const DropInstant drop = frozen_drop(parse_modes(row[0]));
    EXPECT_NEAR(volume_m3(drop) / sphere_volume(1e-3), std::stod(row[1]), 6e-9) << row[0];
    const Eigen::Vector3d centre = centroid_m(drop) / 1e-3;
    EXPECT_NEAR(centre.x(), std::stod(row[4]), 6e-9) << row[0];
    EXPECT_NEAR(centre.z(), std::stod(row[5]), 6e-9) << row[0];
  }
}

TEST(DropShape, VolumeOfTheTwoPublishedModesMatchesTheClosedForm) {
  // The averages of squares and cubes of P20 and P31 cos phi over the sphere, exact.
  for (const double a : {-0.3, -0.1, 0.2, 0.3}) {
    for (const double b : {-0.2, 0.05, 0.1, 0.2}) {
      const double expected =
          1 + 3 * a * a / 5 + 18 * b * b / 7 + 2 * a * a * a / 35 + 18 * a * b * b / 35;
      EXPECT_NEAR(volume_m3(concave_drop(a, b)) / sphere_volume(1e-3), expected, 1e-13) << a << b;
    }
  }
}

TEST(DropShape, KeptVolumeAndCentroidStayWhereTheyWere) {
  DropShape shape;
  shape.mean_radius_m = 1.5e-3;
  shape.modes = {{2, 0, 0.2, 0}, {3, 1, 0.1, 0}, {4, 0, 0.05, 0}};
  shape.equilibrium_cos = {-0.0281, 0.0226, -0.0823};
  shape.phi_drop_rad = 1;
  shape.keep_volume = shape.keep_centroid = true;
  for (const double t : {0.0, 0.0013, 0.004, 0.0071}) {
    const DropInstant drop = drop_at(shape, t);
    EXPECT_NEAR(volume_m3(drop) / sphere_volume(1.5e-3), 1, 1e-14) << t;
    // The star centre moves by origin_m, so that the centroid is at the drop's own origin.
    EXPECT_LT((drop.origin_m + centroid_m(drop)).norm(), 1e-17) << t;
    EXPECT_GT(drop.origin_m.norm(), 1e-6) << t;
  }
}

// r(u) u as a function of the tangent plane's coordinates at u, for differences.
Eigen::Vector3d surface_point(const DropInstant& drop, const Eigen::Vector3d& u,
                              const Eigen::Vector3d& e1, const Eigen::Vector3d& e2, double a,
                              double b) {
  const Eigen::Vector3d v = (u + a * e1 + b * e2).normalized();
  return surface_radius_m(drop, v) * v;
}

std::vector<Eigen::Vector3d> poles_and_random_directions(int count) {
  std::vector<Eigen::Vector3d> directions = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
  Random random(2);
  for (int i = 0; i < count; ++i) directions.push_back(random_direction(random));
  return directions;
}

TEST(DropShape, NormalsAndCurvaturesAreThoseOfCentralDifferences) {
  // Steps of 1e-3: fourth-order terms 1e-6 / 12 times derivatives up to n^4 A ~ 4, and rounding
  // 1e-16 / 1e-6; the curvature (about 1/r^2) to 1e-5 of its largest terms.
  const DropInstant drop = frozen_drop({{2, 0, 0.2, 0}, {3, 1, 0.1, 0}, {4, 3, 0.002, 0}});
  for (const Eigen::Vector3d& u : poles_and_random_directions(200)) {
    const Eigen::Vector3d e1 = u.unitOrthogonal(), e2 = u.cross(e1);
    const double s = 1e-3;
    const auto at = [&](double a, double b) {
      return surface_point(drop, u, e1, e2, a * s, b * s);
    };
    const Eigen::Vector3d xa = (at(1, 0) - at(-1, 0)) / (2 * s);
    const Eigen::Vector3d xb = (at(0, 1) - at(0, -1)) / (2 * s);
    const Eigen::Vector3d normal = xa.cross(xb).normalized();
    EXPECT_LT((surface_normal(drop, u) - normal).norm(), 2e-5) << u.transpose();
    const Eigen::Vector3d xaa = (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / (s * s);
    const Eigen::Vector3d xbb = (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / (s * s);
    const Eigen::Vector3d xab = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * s * s);
    const double first = xa.squaredNorm() * xb.squaredNorm() - std::pow(xa.dot(xb), 2);
    const double l = xaa.dot(normal), m = xab.dot(normal), n = xbb.dot(normal);
    const double size = (std::abs(l * n) + m * m) / first;
    EXPECT_NEAR(gaussian_curvature_1_m2(drop, u), (l * n - m * m) / first, 2e-4 * size + 1)
        << u.transpose();
  }
}

TEST(DropShape, ASphereHasRadialNormalsAndCurvatureOneOverRSquared) {
  const DropInstant sphere = frozen_drop({}, 4e-3);
  for (const Eigen::Vector3d& u : poles_and_random_directions(20)) {
    EXPECT_LT((surface_normal(sphere, u) - u).norm(), 1e-15);
    EXPECT_NEAR(gaussian_curvature_1_m2(sphere, u) * 16e-6, 1, 1e-13);
  }
}

TEST(DropShape, CurvatureAtThePoleOfARotationalBodyIsItsMeridiansSquared) {
  // At the pole of r(theta): k = 1/r - r''/r^2. P_n: r'' = -r0 A n (n + 1) / 2.
  for (const int n : {2, 3, 6, 8}) {
    const double a = 0.05, r = 1 + a;
    const double k = (1 / r + a * n * (n + 1) / 2 / (r * r)) / 1e-3;
    const DropInstant drop = frozen_drop({{.n = n, .amplitude = a}});
    EXPECT_NEAR(gaussian_curvature_1_m2(drop, {0, 0, 1}) / (k * k), 1, 1e-12) << n;
    EXPECT_LT((surface_normal(drop, {0, 0, 1}) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15) << n;
  }
}

TEST(DropShape, TheCurvatureOfAClosedSurfaceAddsUpToFourPi) {
  // Gauss and Bonnet. Midpoints in z, equidistant in phi; the area element of r(u) u per solid
  // angle is r^2 / (normal . u). Midpoint error ~ steps^-2.
  const DropInstant drop = concave_drop(0.2, 0.1);
  double total = 0;
  const int rings = 400, around = 64;
  for (int i = 0; i < rings; ++i) {
    const double z = -1 + (i + 0.5) * 2 / rings, rho = std::sqrt(1 - z * z);
    for (int j = 0; j < around; ++j) {
      const double phi = 2 * pi * j / around;
      const Eigen::Vector3d u = {rho * std::cos(phi), rho * std::sin(phi), z};
      const double r = surface_radius_m(drop, u);
      total += gaussian_curvature_1_m2(drop, u) * r * r / surface_normal(drop, u).dot(u) * 2 /
               rings * 2 * pi / around;
    }
  }
  EXPECT_NEAR(total / (4 * pi), 1, 1e-4);
}

// The smallest radius by a fine grid and then ever smaller random steps: slow and simple.
double searched_minimum_m(const DropInstant& drop, Random& random) {
  Eigen::Vector3d best = {0, 0, 1};
  double smallest = surface_radius_m(drop, best);
  const auto look = [&](const Eigen::Vector3d& u) {
    const double r = surface_radius_m(drop, u);
    if (r >= smallest) return;
    smallest = r;
    best = u;
  };
  for (int i = 0; i < 60000; ++i) look(random_direction(random));
  for (double step = 0.05; step > 1e-7; step *= 0.98) {
    for (int k = 0; k < 8; ++k) look((best + step * random_direction(random)).normalized());
  }
  return smallest;
}

TEST(DropShape, TheMinimumRadiusIsThatOfADenseSearch) {
  // The search ends within 1e-7 rad of the minimum, where the radius differs by 1e-14 n^2.
  Random random(3);
  const std::vector<std::vector<Mode>> drops = {
      {{2, 0, 0.3, 0}, {3, 1, 0.2, 0}},
      {{8, 4, 1e-5, 0}, {5, 0, 0.1, 0}},  // many minima nearly alike
      {{6, 6, 2e-6, 0}, {7, 3, 3e-5, 0}},
      {{2, 0, 1e-7, 0}, {3, 1, 1e-7, 0}},  // a sphere, almost
      {{2, 2, -0.06, 0}}};
  for (const auto& modes : drops) {
    const DropInstant drop = frozen_drop(modes);
    const double searched = searched_minimum_m(drop, random);
    EXPECT_NEAR(minimum_radius_m(drop) / searched, 1, 1e-9) << modes[0].n << modes[0].m;
  }
}

TEST(DropShape, TheMinimumOfARotationalBodyIsFoundAlsoOnARing) {
  // P_4 has its minimum -3/7 on the rings cos^2 theta = 3/7, between any grid's lines; P_2's
  // equator lies at -1/2; -P_2 has its minimum at both poles; P_3 reaches -1 at the bottom.
  EXPECT_NEAR(minimum_radius_m(frozen_drop({{.n = 4, .amplitude = 0.3}})), 1e-3 * (1 - 0.9 / 7),
              1e-13);
  EXPECT_NEAR(minimum_radius_m(frozen_drop({{.n = 2, .amplitude = 0.3}})), 0.85e-3, 1e-13);
  EXPECT_NEAR(minimum_radius_m(frozen_drop({{.n = 2, .amplitude = -0.3}})), 0.7e-3, 1e-13);
  EXPECT_NEAR(minimum_radius_m(frozen_drop({{.n = 3, .amplitude = 0.25}})), 0.75e-3, 1e-13);
  EXPECT_NEAR(minimum_radius_m(frozen_drop({}, 2e-3)), 2e-3, 1e-18);
}

TEST(DropShape, TheMinimumOverTimeIsThatOfTheDeepestInstant) {
  // One mode (2,0) of amplitude 0.2: smallest at sin = -1, r = 0.8 r0 at the poles.
  DropShape shape;
  shape.modes = {{.n = 2, .amplitude = 0.2}};
  const double period = 2 * pi / mode_frequency_rad_s(shape, 2);
  EXPECT_NEAR(minimum_relative_radius(shape, period, 65), 0.8, 1e-9);  // 65: 3/4 of it is met
  EXPECT_NEAR(minimum_relative_radius({}, 1), 1, 1e-15);
}

TEST(DropShape, BoundsHoldAlongRandomGreatCircles) {
  Random random(4);
  for (const auto& modes : {std::vector<Mode>{{2, 0, 0.3, 0}, {3, 1, 0.2, 0}},
                            std::vector<Mode>{{8, 3, 1e-4, 0}, {10, 10, 1e-10, 0}}}) {
    const DropInstant drop = frozen_drop(modes);
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d u = random_direction(random), v = u.unitOrthogonal();
      const auto h = [&](double psi) {
        const Eigen::Vector3d w = std::cos(psi) * u + std::sin(psi) * v;
        return surface_radius_m(drop, w) / 1e-3;
      };
      const double s = 1e-3;
      EXPECT_LE(std::abs(h(0)), drop.bound_h);
      EXPECT_LE(std::abs(h(s) - h(-s)) / (2 * s), drop.bound_slope);
      EXPECT_LE(std::abs(h(s) - 2 * h(0) + h(-s)) / (s * s), drop.bound_bend);
    }
  }
}

}  // namespace
}  // namespace pluvia
