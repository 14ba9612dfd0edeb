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

// The direction through (u, v) of the plane at distance 1 on the cone's axis.
Eigen::Vector3d direction_to(const Cone& cone, double u, double v) {
  const Eigen::Vector3d across = cone.axis.unitOrthogonal();
  return cone.axis + u * across + v * cone.axis.cross(across);
}

ConeVertex vertex(const Eigen::Vector3d& d, double x, double y, double throughput = 1,
                  double facing = 1) {
  return {d.x(), d.y(), d.z(), x, y, throughput, facing, 1};
}

// A corner whose picture is its gnomonic plane, so that areas can be compared.
ConeVertex corner(const Cone& cone, double u, double v, double throughput = 1) {
  return vertex(direction_to(cone, u, v), u, v, throughput);
}

ConeVertex random_corner(Random& random, const Cone& cone, double size) {
  const double u = uniform(random, -size, size), v = uniform(random, -size, size);
  const double x = uniform(random, -size, size), y = uniform(random, -size, size);
  return vertex(direction_to(cone, u, v), x, y, uniform(random, 0, 1));
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
        corners.push_back(corner(cone, size * std::cos(angle), size * std::sin(angle)));
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
    ConePolygon polygon = polygon_of(
        {corner(cone, 9 * c, 9 * s), corner(cone, -9 * c, -9 * s), corner(cone, 9 * s, -9 * c)});
    clip_to_cone(cone, polygon);
    EXPECT_NEAR(polygon_flux(polygon).area / (pi * std::pow(std::tan(0.1), 2)), 0.5, 1e-12) << turn;
  }
}

TEST(ConeClip, TrianglesInsideStayAsTheyAreAndOutsideVanish) {
  const Cone cone = make_cone({0, 0, 1}, 0.2);
  ConePolygon inside = polygon_of({corner(cone, 0, 0), corner(cone, 0.1, 0), corner(cone, 0, 0.1)});
  clip_to_cone(cone, inside);
  EXPECT_EQ(inside.count, 3);
  EXPECT_DOUBLE_EQ(polygon_flux(inside).area, 0.005);
  ConePolygon outside =
      polygon_of({corner(cone, 0.3, 0), corner(cone, 0.3, 1), corner(cone, 1, 0)});
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
    const Eigen::Vector3d d = r * Eigen::Vector3d(a.dx, a.dy, a.dz) +
                              s * Eigen::Vector3d(b.dx, b.dy, b.dz) +
                              t * Eigen::Vector3d(c.dx, c.dy, c.dz);
    const double here = share * (r * a.throughput + s * b.throughput + t * c.throughput);
    const double along = d.dot(cone.axis);
    const double radius = along > 0 ? d.cross(cone.axis).norm() / along / limit : 1e9;
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
    const ConePolygon triangle =
        polygon_of({random_corner(random, cone, 0.5), random_corner(random, cone, 0.5),
                    random_corner(random, cone, 0.5)});
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
  const Cone cone = make_cone({0, 0, 1}, 0.3);
  for (int i = 0; i < 500; ++i) {
    ConePolygon whole = polygon_of({random_corner(random, cone, 5), random_corner(random, cone, 5),
                                    random_corner(random, cone, 5)});
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
  // 3 corners and 16 + 4 cuts: at most 23 of 24, also for needles and for triangles of no area.
  Random random(3);
  const Cone cone = make_cone({0, 0, 1}, 0.3);
  for (int i = 0; i < 20000; ++i) {
    std::vector<ConeVertex> corners = {
        random_corner(random, cone, 0.6), random_corner(random, cone, 0.6), {}};
    const double t = uniform(random, -1, 2), off = i % 2 == 0 ? 0 : 1e-16;
    corners[2] = corners[0];
    corners[2].dx += t * (corners[1].dx - corners[0].dx) + off;
    corners[2].dy += t * (corners[1].dy - corners[0].dy);
    corners[2].facing = uniform(random, -1, 1);
    corners[1].margin = uniform(random, -1, 1);
    if (i % 3 == 0) corners[1] = corners[0];
    ConePolygon polygon = polygon_of(corners);
    clip_to_facing(polygon);
    clip_to_margin(polygon);
    clip_to_cone(cone, polygon);
    clip_to_columns(polygon, -0.1, 0.2);
    ASSERT_LE(polygon.count, 23) << i;
    ASSERT_TRUE(std::isfinite(amount(polygon))) << i;
  }
}

TEST(ConeClip, CornersFarOffTheAxisAndBehindItAreClippedAsWell) {
  // A great triangle around the axis, its corners 60 to 120 degrees away: its picture is the plane
  // in which directions are linear, so that what is left is what random points of it find. 4
  // standard deviations of 10^6 points, and the rim as above.
  Random random(4);
  for (const double angle : {1.0, 1.5, 2.1}) {
    const Cone cone = make_cone({0, 0, 1}, 0.3);
    std::vector<ConeVertex> corners;
    for (int k = 0; k < 3; ++k) {
      const double turn = 2 * pi * k / 3 + 0.2;
      const Eigen::Vector3d d = {std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                                 std::cos(angle)};
      corners.push_back(vertex(d, std::cos(turn), std::sin(turn)));
    }
    const ConePolygon triangle = polygon_of(corners);
    ConePolygon clipped = triangle;
    clip_to_cone(cone, clipped);
    const Sampled expected = sampled_amount(cone, triangle, random, 1000000);
    EXPECT_NEAR(amount(clipped), expected.amount,
                expected.rim + 0.002 * polygon_flux(triangle).area)
        << angle;
    EXPECT_EQ(expected.amount > 0, angle < pi / 2) << "behind the apex nothing is in the cone";
  }
}

TEST(ConeClip, OnlyWhatFacesTheCameraIsKept) {
  // Facing falls from 1 to -1 along a unit right triangle's legs: half of each leg stays.
  ConePolygon polygon = polygon_of({vertex({0, 0, 1}, 0, 0, 1, 1), vertex({0, 0, 1}, 1, 0, 1, -1),
                                    vertex({0, 0, 1}, 0, 1, 1, -1)});
  clip_to_facing(polygon);
  EXPECT_DOUBLE_EQ(polygon_flux(polygon).area, 0.125);
}

TEST(ConeClip, LightFadesToNothingWhereReflectionIsTotal) {
  // Margin falls from 1 to -1 along a unit right triangle's legs, throughput from 1 to 0 (dark
  // behind the edge): half of each leg stays, and the two new corners are dark: a third of 1 in the
  // mean.
  std::vector<ConeVertex> corners = {vertex({0, 0, 1}, 0, 0, 1), vertex({0, 0, 1}, 1, 0, 0),
                                     vertex({0, 0, 1}, 0, 1, 0)};
  corners[1].margin = corners[2].margin = -1;
  ConePolygon polygon = polygon_of(corners);
  clip_to_margin(polygon);
  EXPECT_DOUBLE_EQ(polygon_flux(polygon).area, 0.125);
  EXPECT_DOUBLE_EQ(polygon_flux(polygon).throughput, 1.0 / 3);
}

TEST(ConeClip, AreaIsPositiveEitherWayRoundAndThroughputItsMean) {
  const Eigen::Vector3d d = {0, 0, 1};
  const PolygonFlux one =
      polygon_flux(polygon_of({vertex(d, 0, 0, 1), vertex(d, 2, 0, 2), vertex(d, 0, 2, 6)}));
  const PolygonFlux other =
      polygon_flux(polygon_of({vertex(d, 0, 0, 1), vertex(d, 0, 2, 6), vertex(d, 2, 0, 2)}));
  EXPECT_DOUBLE_EQ(one.area, 2);
  EXPECT_DOUBLE_EQ(one.throughput, 3);
  EXPECT_DOUBLE_EQ(other.area, 2);
  EXPECT_DOUBLE_EQ(other.throughput, 3);
}

}  // namespace
}  // namespace pluvia
