#include "raytrace/drop_intersect.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// Height of a point over the surface along its radius, relative to r0 = 1 mm; < 0 inside.
double height(const DropInstant& drop, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = p - drop.origin_m;
  const double length = q.norm();
  return (length - surface_radius_m(drop, Eigen::Vector3d(q / length))) / 1e-3;
}

struct Ray {
  Eigen::Vector3d origin = {0, 0, 0}, direction = {0, 0, 1};
  Eigen::Vector3d at(double t) const { return origin + t * direction; }
};

// First change of side between `from` and `to`, by steps and bisection; the second road.
std::optional<double> scanned(const DropInstant& drop, const Ray& ray, double from, double to,
                              int steps) {
  double before = from;
  const bool started_inside = height(drop, ray.at(from)) < 0;
  for (int k = 1; k <= steps; ++k) {
    double after = from + (to - from) * k / steps;
    if ((height(drop, ray.at(after)) < 0) != started_inside) {
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (before + after);
        const bool same = (height(drop, ray.at(middle)) < 0) == started_inside;
        (same ? before : after) = middle;
      }
      return 0.5 * (before + after);
    }
    before = after;
  }
  return std::nullopt;
}

// The hit is on the ray and on the surface, with its normal; nothing was crossed before it.
void expect_first_root(const DropInstant& drop, const Ray& ray, const DropHit& hit, double from,
                       int steps) {
  ASSERT_LT((ray.at(hit.distance) - hit.position).norm(), 1e-12) << "off the ray";
  ASSERT_NEAR(height(drop, hit.position), 0, 1e-12) << "off the surface";
  const Eigen::Vector3d u = (hit.position - drop.origin_m).normalized();
  ASSERT_LT((hit.normal - surface_normal(drop, u)).norm(), 1e-11);
  const auto first = scanned(drop, ray, from, hit.distance + 1e-9, steps);
  // A crossing not shown by the scan can only be one that it steps over: a touch at the hit itself.
  if (first) {
    ASSERT_NEAR(*first, hit.distance, 1e-12) << "an earlier crossing";
  }
}

void expect_no_root(const DropInstant& drop, const Ray& ray, double from, double to, int steps) {
  const auto first = scanned(drop, ray, from, to, steps);
  ASSERT_FALSE(first) << "missed a crossing at " << *first << " m, depth "
                      << height(drop, ray.at(*first + 1e-6)) << " r0 1 um later";
}

Ray random_outer_ray(Random& random) {
  Ray ray;
  ray.origin = 4e-3 * random_direction(random);
  const Eigen::Vector3d aim = uniform(random, 0, 1.5e-3) * random_direction(random);
  ray.direction = (aim - ray.origin).normalized();
  return ray;
}

void try_outer_rays(const DropInstant& drop, Random& random, int rays, int steps) {
  for (int i = 0; i < rays; ++i) {
    const Ray ray = random_outer_ray(random);
    const auto hit = intersect_drop(drop, ray.origin, ray.direction, RaySide::outside);
    ASSERT_EQ(drop_occludes(drop, ray.origin, ray.direction), hit.has_value());
    if (hit) {
      ASSERT_LT(hit->normal.dot(ray.direction), 1e-6) << "met from behind";
      expect_first_root(drop, ray, *hit, 2e-3, steps);
    } else {
      expect_no_root(drop, ray, 2e-3, 6e-3, steps);
    }
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(DropIntersect, FindsTheFirstCrossingFromOutside) {
  Random random(1);
  for (const DropInstant& drop : hard_drops()) {
    try_outer_rays(drop, random, 3000, 400);
    try_outer_rays(drop, random, 30, 10000);
  }
}

TEST(DropIntersect, FindsTheFirstCrossingFromPointsOnTheSurfaceInward) {
  Random random(2);
  for (const DropInstant& drop : hard_drops()) {
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d u = random_direction(random);
      Ray ray;
      ray.origin = drop.origin_m + surface_radius_m(drop, u) * u;
      ray.direction = random_direction(random);
      // At least 0.3 degrees into the surface, so that 1 nm further the scan stands inside.
      if (surface_normal(drop, u).dot(ray.direction) > -0.005) continue;
      const auto hit = intersect_drop(drop, ray.origin, ray.direction, RaySide::inside);
      ASSERT_TRUE(hit) << i;
      ASSERT_GT(hit->distance, 1e-9);
      expect_first_root(drop, ray, *hit, 1e-9, 300);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(DropIntersect, FindsWhatALeavingRayMeetsAgain) {
  Random random(3);
  int met_again = 0;
  for (const DropInstant& drop : hard_drops()) {
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d u = random_direction(random);
      const Eigen::Vector3d normal = surface_normal(drop, u);
      Ray ray;
      ray.origin = drop.origin_m + surface_radius_m(drop, u) * u;
      // Low over the surface, where a concave drop is met again.
      ray.direction = (random_direction(random).cross(normal).normalized() +
                       uniform(random, 0.005, 0.3) * normal)
                          .normalized();
      const auto hit = intersect_drop(drop, ray.origin, ray.direction, RaySide::outside);
      if (hit) {
        ++met_again;
        ASSERT_GT(hit->distance, 1e-9);
        expect_first_root(drop, ray, *hit, 1e-9, 400);
      } else {
        expect_no_root(drop, ray, 1e-9, 4e-3, 400);
      }
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(met_again, 500);  // the drops are concave indeed
}

TEST(DropIntersect, ASphereIsMetUpToItsRimAndNotBeyond) {
  // The chord's half length sqrt(R^2 - b^2) has the error of b over itself: 1e-16 / 1e-6 at the
  // rim.
  for (const double r0 : {0.05e-3, 1e-3, 4e-3}) {
    const DropInstant sphere = frozen_drop({}, r0);
    for (const double lack : {1.0, 0.5, 1e-3, 1e-6, 1e-9, 1e-12}) {
      const double b = 1 - lack;
      const Eigen::Vector3d origin = {5 * r0, b * r0, 0}, direction = {-1, 0, 0};
      const auto hit = intersect_drop(sphere, origin, direction, RaySide::outside);
      ASSERT_TRUE(hit) << lack;
      const double half_chord = std::sqrt(lack * (2 - lack));
      EXPECT_NEAR(hit->distance / r0, 5 - half_chord, 1e-14 / half_chord) << lack;
      const auto out = intersect_drop(sphere, hit->position, direction, RaySide::inside);
      ASSERT_TRUE(out) << lack;
      EXPECT_NEAR(out->distance / r0, 2 * half_chord, 1e-13 / half_chord) << lack;
    }
    for (const double excess : {1e-12, 1e-6, 0.5}) {
      const Eigen::Vector3d origin = {5 * r0, (1 + excess) * r0, 0};
      EXPECT_FALSE(intersect_drop(sphere, origin, {-1, 0, 0}, RaySide::outside)) << excess;
    }
  }
}

TEST(DropIntersect, RaysAlongTheTangentAreMetJustBelowItAndSeenPastJustAbove) {
  // Tangents in the direction of each random turn, moved by -+1e-7 r0 along the normal: what the
  // scan says about the neighbourhood is beyond doubt at points of the convex rim.
  Random random(4);
  for (const DropInstant& drop : hard_drops()) {
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d u = random_direction(random), normal = surface_normal(drop, u);
      const Eigen::Vector3d touch = drop.origin_m + surface_radius_m(drop, u) * u;
      Ray ray;
      ray.direction = normal.cross(random_direction(random)).normalized();
      const double offset = (i % 2 == 0 ? -1e-10 : 1e-10);
      ray.origin = touch - 4e-3 * ray.direction + offset * normal;
      const auto hit = intersect_drop(drop, ray.origin, ray.direction, RaySide::outside);
      if (offset < 0) {
        ASSERT_TRUE(hit) << "a point of the ray lies inside";
        ASSERT_LT(hit->distance, 4e-3);
      }
      if (!hit) {
        expect_no_root(drop, ray, 1e-3, 7e-3, 300);
      } else {
        expect_first_root(drop, ray, *hit, 1e-3, 300);
      }
      if (HasFatalFailure()) return;
    }
  }
}

TEST(DropIntersect, RaysThroughTheCentreMeetTheRadius) {
  Random random(5);
  for (const DropInstant& drop : hard_drops()) {
    std::vector<Eigen::Vector3d> directions = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                               {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (int i = 0; i < 20; ++i) directions.push_back(random_direction(random));
    for (const Eigen::Vector3d& u : directions) {
      const double r = surface_radius_m(drop, u);
      const auto in = intersect_drop(drop, drop.origin_m + 5e-3 * u, -u, RaySide::outside);
      ASSERT_TRUE(in);
      EXPECT_NEAR(in->distance, 5e-3 - r, 1e-17) << u.transpose();
      const auto out = intersect_drop(drop, drop.origin_m, u, RaySide::inside);
      ASSERT_TRUE(out);
      EXPECT_NEAR(out->distance, r, 1e-17) << u.transpose();
      EXPECT_FALSE(intersect_drop(drop, drop.origin_m + 5e-3 * u, u, RaySide::outside));
    }
  }
}

TEST(DropIntersect, SizeOnlyScales) {
  // 0.05 mm and 4 mm against 1 mm: positions scale to rounding, times 1e3 for slanted meetings.
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Ray ray = random_outer_ray(random);
    const auto hit = intersect_drop(concave_drop(), ray.origin, ray.direction, RaySide::outside);
    for (const double size : {0.05, 4.0}) {
      const auto scaled = intersect_drop(concave_drop(0.3, 0.2, size * 1e-3), size * ray.origin,
                                         ray.direction, RaySide::outside);
      ASSERT_EQ(scaled.has_value(), hit.has_value());
      if (!hit || hit->normal.dot(ray.direction) > -1e-3) continue;
      EXPECT_NEAR(scaled->distance / size, hit->distance, 1e-15) << i;
    }
  }
}

}  // namespace
}  // namespace pluvia
