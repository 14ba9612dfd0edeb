#include "raytrace/embree_drop.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

void expect_same_bits(const std::optional<DropHit>& a, const std::optional<DropHit>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (!a) return;
  EXPECT_EQ(a->distance, b->distance);
  EXPECT_TRUE(a->position == b->position);
  EXPECT_TRUE(a->normal == b->normal);
}

// The direction from `origin` to a random point of the ball of 1.5 r0.
Eigen::Vector3d random_aim(const Eigen::Vector3d& origin, double r0, Random& random) {
  return (uniform(random, 0, 1.5 * r0) * random_direction(random) - origin).normalized();
}

TEST(EmbreeDrop, GivesTheSameDoublesAsTheAnalyticDropFromOutside) {
  Random random(1);
  for (const double r0 : {0.05e-3, 1e-3, 4e-3}) {
    const EmbreeDrop embree(1.8 * r0);
    for (const double a20 : {-0.3, 0.0, 0.3}) {  // one scene serves all instants
      const DropInstant drop = concave_drop(a20, 0.2, r0);
      int hits = 0;
      for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d origin = 4 * r0 * random_direction(random);
        const Eigen::Vector3d direction = random_aim(origin, r0, random);
        const auto expected = intersect_drop(drop, origin, direction, RaySide::outside);
        expect_same_bits(embree.intersect(drop, origin, direction, RaySide::outside), expected);
        hits += expected ? 1 : 0;
      }
      EXPECT_GT(hits, 500);
      EXPECT_LT(hits, 1950);
    }
  }
}

TEST(EmbreeDrop, GivesTheSameDoublesFromTheSurfaceToBothSides) {
  Random random(2);
  const DropInstant drop = concave_drop();
  const EmbreeDrop embree(1.8e-3);
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d u = random_direction(random), direction = random_direction(random);
    const Eigen::Vector3d origin = surface_radius_m(drop, u) * u;
    const bool outward = surface_normal(drop, u).dot(direction) > 0;
    const RaySide side = outward ? RaySide::outside : RaySide::inside;
    expect_same_bits(embree.intersect(drop, origin, direction, side),
                     intersect_drop(drop, origin, direction, side));
  }
}

TEST(EmbreeDrop, RaysThatPassTheBoundingBoxMeetNothing) {
  const EmbreeDrop embree(1.8e-3);
  const DropInstant drop = concave_drop();
  EXPECT_FALSE(embree.intersect(drop, {5e-3, 4e-3, 0}, {-1, 0, 0}, RaySide::outside));
  EXPECT_FALSE(embree.intersect(drop, {5e-3, 0, 0}, {1, 0, 0}, RaySide::outside));
}

struct MeshError {
  double distance_m = 0, normal = 0;  // root mean squares
};

MeshError mesh_error(const DropInstant& drop, int levels) {
  const SphereMesh sphere = sphere_mesh(levels);
  const MeshDrop mesh(drop, sphere);
  Random random(3);
  MeshError sum;
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d origin = 4e-3 * random_direction(random);
    const Eigen::Vector3d direction = random_aim(origin, 0.5e-3, random);
    const auto exact = intersect_drop(drop, origin, direction, RaySide::outside);
    const auto hit = mesh.intersect(origin, direction);
    // Steep meetings only: at the rim either may miss.
    if (!exact || exact->normal.dot(direction) > -0.4) continue;
    if (!hit) continue;
    ++hits;
    sum.distance_m += std::pow(hit->distance - exact->distance, 2);
    sum.normal += (hit->normal - exact->normal).squaredNorm();
  }
  EXPECT_GT(hits, 2000);
  return {std::sqrt(sum.distance_m / hits), std::sqrt(sum.normal / hits)};
}

TEST(MeshDrop, ErrorsFallAsOneOverTheNumberOfTriangles) {
  // Linear interpolation errs by the square of the edge, and a level halves the edges: 4, within 15
  // % for the higher orders that are left.
  const DropInstant drop = concave_drop(0.15, 0.05);
  const std::array<MeshError, 3> errors = {mesh_error(drop, 3), mesh_error(drop, 4),
                                           mesh_error(drop, 5)};
  for (std::size_t k = 1; k < errors.size(); ++k) {
    EXPECT_NEAR(errors[k - 1].distance_m / errors[k].distance_m, 4, 0.6) << k;
    EXPECT_NEAR(errors[k - 1].normal / errors[k].normal, 4, 0.6) << k;
  }
  EXPECT_LT(errors[2].distance_m, 1e-6);
}

TEST(MeshDrop, APolishedHitIsWhereTheRayMeetsTheAnalyticSurface) {
  const DropInstant drop = concave_drop(0.15, 0.05);
  const SphereMesh sphere = sphere_mesh(3);
  const MeshDrop mesh(drop, sphere);
  Random random(5);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin = 4e-3 * random_direction(random);
    const Eigen::Vector3d direction = random_aim(origin, 0.5e-3, random);
    const auto exact = intersect_drop(drop, origin, direction, RaySide::outside);
    const auto hit = mesh.intersect_polished(drop, origin, direction);
    if (!exact || !hit || exact->normal.dot(direction) > -0.4) continue;
    ++hits;
    // Newton ends 1e-12 r0 above or below; along a ray this steep that is 2.5 times as far.
    EXPECT_NEAR(hit->distance, exact->distance, 4e-12 * drop.surface.scale);
    EXPECT_LT((hit->normal - exact->normal).norm(), 1e-10);
  }
  EXPECT_GT(hits, 1000);
}

TEST(SphereMesh, LiesBelowTheSphereByAQuarterAsMuchWithEveryLevel) {
  // A chord of edge e lies e^2 / 8 below; the second order that is left of coarse levels is 5 %.
  for (int levels = 3; levels < 6; ++levels) {
    EXPECT_NEAR(sphere_mesh(levels).gap / sphere_mesh(levels + 1).gap, 4, 0.2) << levels;
  }
}

TEST(MeshDrop, HasEightTimesFourToTheLevelsTrianglesAndItsCornersOnTheSurface) {
  DropShape shape;
  shape.modes = {{2, 0, 0.2, 1}, {3, 1, 0.1, 1}};
  shape.keep_centroid = true;  // the surface is moved: so must the mesh be
  const DropInstant drop = drop_at(shape, 0);
  const SphereMesh coarsest = sphere_mesh(0), finer = sphere_mesh(3);
  const MeshDrop octahedron(drop, coarsest), fine(drop, finer);
  EXPECT_EQ(octahedron.triangle_count(), 8u);
  EXPECT_EQ(fine.triangle_count(), 512u);
  for (const Eigen::Vector3d& u : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, -1)}) {
    // A ray down to a corner, moved a millionth to the side to meet a triangle, not its edge.
    const Eigen::Vector3d aside = 1e-9 * u.cross(Eigen::Vector3d(0.3, 0.5, 0.7));
    const auto hit = fine.intersect(drop.origin_m + 4e-3 * u + aside, -u);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, 4e-3 - surface_radius_m(drop, u), 1e-8);  // floats
    EXPECT_LT((hit->normal - surface_normal(drop, u)).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace pluvia
