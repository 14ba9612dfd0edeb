#include "raytrace/cone_clip.h"

#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

ConePolygon polygon_of(const std::vector<ConeVertex>& corners) {
  ConePolygon polygon;
  polygon.count = static_cast<int>(corners.size());
  std::copy(corners.begin(), corners.end(), polygon.vertices.begin());
  return polygon;
}

// A corner whose picture is its gnomonic plane, so that areas can be compared.
ConeVertex corner(double u, double v, double throughput = 1) {
  return {u, v, u, v, throughput};
}

ConeVertex random_corner(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size),
          uniform(random, -size, size), uniform(random, 0, 1)};
}

double amount(const ConePolygon& polygon) {
  const PolygonFlux flux = polygon_flux(polygon);
  return flux.area * flux.throughput;
}

TEST(ConeClip, ATriangleAroundTheConeKeepsExactlyTheDiscsArea) {
  // The 16-gon is defined by area pi tan^2.
  for (const double degrees : {0.05, 1.0, 5.0, 30.0, 44.0}) {
    const Cone cone = make_cone(Eigen::Vector3d(1, 2, -3).normalized(), degrees * pi / 180);
    const double disc = pi * std::pow(std::tan(degrees * pi / 180), 2);
    const double size = 10 * std::tan(degrees * pi / 180);
    for (const double turn : {0.0, 0.7, 2.0}) {
      std::vector<ConeVertex> corners;
      for (int k = 0; k < 3; ++k) {
        const double angle = turn + 2 * pi * k / 3;
        corners.push_back(corner(size * std::cos(angle), size * std::sin(angle)));
      }
      ConePolygon polygon = polygon_of(corners);
      clip_to_cone(cone, polygon);
      EXPECT_EQ(polygon.count, 16);
      EXPECT_NEAR(polygon_flux(polygon).area / disc, 1, 1e-12) << degrees;
    }
  }
}

TEST(ConeClip, AHalfPlaneThroughTheAxisKeepsHalf) {
  // By symmetry, whatever the turn.
  const Cone cone = make_cone({0, 0, 1}, 0.1);
  for (double turn = 0; turn < 3; turn += 0.37) {
    const double c = std::cos(turn), s = std::sin(turn);
    ConePolygon polygon =
        polygon_of({corner(9 * c, 9 * s), corner(-9 * c, -9 * s), corner(9 * s, -9 * c)});
    clip_to_cone(cone, polygon);
    EXPECT_NEAR(polygon_flux(polygon).area / (pi * std::pow(std::tan(0.1), 2)), 0.5, 1e-12) << turn;
  }
}

TEST(ConeClip, TrianglesInsideStayAsTheyAreAndOutsideVanish) {
  const Cone cone = make_cone({0, 0, 1}, 0.2);
  ConePolygon inside = polygon_of({corner(0, 0), corner(0.1, 0), corner(0, 0.1)});
  clip_to_cone(cone, inside);
  EXPECT_EQ(inside.count, 3);
  EXPECT_DOUBLE_EQ(polygon_flux(inside).area, 0.005);
  ConePolygon outside = polygon_of({corner(0.3, 0), corner(0.3, 1), corner(1, 0)});
  clip_to_cone(cone, outside);
  EXPECT_EQ(polygon_flux(outside).area, 0);
  EXPECT_EQ(polygon_flux(outside).throughput, 0);  // not 0 / 0
}

struct Sampled {
  double amount = 0;  // of the triangle's picture within the disc, times throughput
  double rim = 0;     // .. within 1.4 % of the disc's rim, where disc and 16-gon may differ
};

Sampled sampled_amount(const Cone& cone, const ConePolygon& triangle, Random& random, int points) {
  const auto& [a, b, c] =
      std::tie(triangle.vertices[0], triangle.vertices[1], triangle.vertices[2]);
  const double share = polygon_flux(triangle).area / points;
  const double limit = std::tan(cone.half_angle_rad);
  Sampled sum;
  for (int i = 0; i < points; ++i) {
    double s = uniform(random, 0, 1), t = uniform(random, 0, 1);
    if (s + t > 1) s = 1 - s, t = 1 - t;
    const double r = 1 - s - t;
    const double u = r * a.u + s * b.u + t * c.u, v = r * a.v + s * b.v + t * c.v;
    const double here = share * (r * a.throughput + s * b.throughput + t * c.throughput);
    const double radius = std::hypot(u, v) / limit;
    if (radius < 1) sum.amount += here;
    if (std::abs(radius - 1) < 0.014) sum.rim += here;
  }
  return sum;
}

TEST(ConeClip, RandomTrianglesKeepWhatRandomPointsFind) {
  // 4 standard deviations of 10^5 points (0.5 / sqrt(1e5) of the area each), and what lies in the
  // band in which the 16-gon (corners at 1.013, sides at 0.994 of the radius) differs from the
  // disc.
  const Cone cone = make_cone({0, 0, 1}, 0.3);
  Random random(1);
  int compared = 0;
  for (int i = 0; i < 60; ++i) {
    const ConePolygon triangle = polygon_of(
        {random_corner(random, 0.5), random_corner(random, 0.5), random_corner(random, 0.5)});
    ConePolygon clipped = triangle;
    clip_to_cone(cone, clipped);
    const Sampled expected = sampled_amount(cone, triangle, random, 100000);
    const double tolerance = expected.rim + 0.0064 * polygon_flux(triangle).area;
    EXPECT_NEAR(amount(clipped), expected.amount, tolerance) << i;
    compared += expected.amount > 0 ? 1 : 0;
  }
  EXPECT_GT(compared, 40);
}

TEST(ConeClip, ColumnsPartitionThePolygon) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    ConePolygon whole =
        polygon_of({random_corner(random, 5), random_corner(random, 5), random_corner(random, 5)});
    if (i % 5 == 0) whole.vertices[1].x = std::floor(whole.vertices[1].x);  // exactly on an edge
    if (i % 7 == 0) whole.vertices[2].x = whole.vertices[1].x;              // an upright side
    double area = 0, sum = 0;
    for (int column = -6; column < 6; ++column) {
      ConePolygon part = whole;
      clip_to_columns(part, column, column + 1);
      area += polygon_flux(part).area;
      sum += amount(part);
    }
    EXPECT_NEAR(area, polygon_flux(whole).area, 1e-13) << i;
    EXPECT_NEAR(sum, amount(whole), 1e-13) << i;
  }
}

TEST(ConeClip, CutPolygonsFitTheirRoomAlsoWhenTheyAreSlivers) {
  // 3 corners and 16 + 2 cuts: at most 21 of 24, also for needles and for triangles of no area.
  Random random(3);
  const Cone cone = make_cone({0, 0, 1}, 0.3);
  for (int i = 0; i < 20000; ++i) {
    std::vector<ConeVertex> corners = {random_corner(random, 0.6), random_corner(random, 0.6), {}};
    const double t = uniform(random, -1, 2), off = i % 2 == 0 ? 0 : 1e-16;
    corners[2] = corners[0];
    corners[2].u += t * (corners[1].u - corners[0].u) + off;
    corners[2].v += t * (corners[1].v - corners[0].v);
    if (i % 3 == 0) corners[1] = corners[0];
    ConePolygon polygon = polygon_of(corners);
    clip_to_cone(cone, polygon);
    clip_to_columns(polygon, -0.1, 0.2);
    ASSERT_LE(polygon.count, 21) << i;
    ASSERT_TRUE(std::isfinite(amount(polygon))) << i;
  }
}

TEST(ConeClip, GnomonicCoordinatesAreTangentsOfTheAngleFromTheAxis) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Cone cone = make_cone(random_direction(random), 0.1);
    const Eigen::Vector3d d = random_direction(random);
    const double cosine = d.dot(cone.axis);
    ConeVertex vertex = {7, 7, 7, 7, 7};
    const bool usable = gnomonic(cone, d, vertex);
    EXPECT_EQ(usable, cosine >= 0.2);
    if (usable) {
      EXPECT_NEAR(std::hypot(vertex.u, vertex.v), d.cross(cone.axis).norm() / cosine, 1e-14);
    } else {
      EXPECT_EQ(vertex.u, 7);
    }
    EXPECT_EQ(vertex.x, 7);
  }
}

TEST(ConeClip, AreaIsPositiveEitherWayRoundAndThroughputItsMean) {
  const PolygonFlux one =
      polygon_flux(polygon_of({{0, 0, 0, 0, 1}, {0, 0, 2, 0, 2}, {0, 0, 0, 2, 6}}));
  const PolygonFlux other =
      polygon_flux(polygon_of({{0, 0, 0, 0, 1}, {0, 0, 0, 2, 6}, {0, 0, 2, 0, 2}}));
  EXPECT_DOUBLE_EQ(one.area, 2);
  EXPECT_DOUBLE_EQ(one.throughput, 3);
  EXPECT_DOUBLE_EQ(other.area, 2);
  EXPECT_DOUBLE_EQ(other.throughput, 3);
}

}  // namespace
}  // namespace pluvia
