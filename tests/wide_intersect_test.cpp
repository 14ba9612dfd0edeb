#include "raytrace/wide_intersect.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"
#include "tests/wide_samples.h"

namespace pluvia {
namespace {

class WideIntersect : public testing::Test {
 protected:
  void SetUp() override {
    if (isas.empty()) GTEST_SKIP() << "this processor has neither AVX2 nor AVX-512";
  }
  const std::vector<Isa> isas = wide_isas();
};

std::vector<DropInstant> drops() {
  std::vector<DropInstant> drops = hard_drops();
  drops.push_back(frozen_drop({}));
  drops.push_back(concave_drop(0.1, 0.05, 0.05e-3));
  return drops;
}

// Rays from afar: half of them anywhere near the drop, half along a tangent, 1e-7 r0 off it.
std::vector<DropRay> outer_rays(const DropInstant& drop, Random& random, int count) {
  const double r0 = drop.surface.scale;
  std::vector<DropRay> rays;
  for (int i = 0; i < count; ++i) {
    DropRay ray;
    const Eigen::Vector3d u = random_direction(random);
    if (i % 2 == 0) {
      ray.origin_m = 4 * r0 * u;
      const Eigen::Vector3d aim = uniform(random, 0, 1.5 * r0) * random_direction(random);
      ray.direction = (aim - ray.origin_m).normalized();
    } else {
      const Eigen::Vector3d normal = surface_normal(drop, u);
      ray.direction = normal.cross(random_direction(random)).normalized();
      ray.origin_m = drop.origin_m + surface_radius_m(drop, u) * u - 4 * r0 * ray.direction +
                     (i % 4 == 1 ? -1e-7 : 1e-7) * r0 * normal;
    }
    rays.push_back(ray);
  }
  return rays;
}

// Rays from points of the surface, into the drop or out of it and low over it.
std::vector<DropRay> surface_rays(const DropInstant& drop, Random& random, int count, bool inward) {
  std::vector<DropRay> rays;
  while (rays.size() < static_cast<std::size_t>(count)) {
    const Eigen::Vector3d u = random_direction(random), normal = surface_normal(drop, u);
    const double height = inward ? -uniform(random, 0.005, 1) : uniform(random, 0.005, 0.3);
    const Eigen::Vector3d along = normal.cross(random_direction(random)).normalized();
    rays.push_back(
        {drop.origin_m + surface_radius_m(drop, u) * u, (along + height * normal).normalized()});
  }
  return rays;
}

// Both roads stop where |G| is below 4e-15 of r0. Where they arrive, G' = sin(angle between ray and
// surface) to a factor of the drop's shape below 10; the way along the ray differs by their ratio.
void expect_as_scalar(const DropInstant& drop, const std::vector<DropRay>& rays, RaySide side,
                      Isa isa) {
  const auto wide = intersect_drop_of(drop, rays, side, isa);
  ASSERT_EQ(wide.size(), rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto hit = intersect_drop(drop, rays[i].origin_m, rays[i].direction, side);
    ASSERT_EQ(wide[i].has_value(), hit.has_value()) << isa_name(isa) << ", ray " << i;
    if (!hit) continue;
    const double slant = std::abs(hit->normal.dot(rays[i].direction));
    const double tolerance = 1e-14 + 10 * walk_root_tolerance / slant;
    const double scale = drop.surface.scale;
    ASSERT_NEAR(wide[i]->distance / scale, hit->distance / scale, tolerance) << i;
    ASSERT_LT((wide[i]->position - hit->position).norm() / scale, tolerance) << i;
    ASSERT_LT((wide[i]->normal - hit->normal).norm(), 100 * tolerance) << i;
  }
}

TEST_F(WideIntersect, FindsWhatTheScalarWalkFinds) {
  Random random(1);
  for (const DropInstant& drop : drops()) {
    const auto outer = outer_rays(drop, random, 2003);
    const auto inward = surface_rays(drop, random, 2003, true);
    const auto leaving = surface_rays(drop, random, 2003, false);
    for (const Isa isa : isas) {
      expect_as_scalar(drop, outer, RaySide::outside, isa);
      expect_as_scalar(drop, inward, RaySide::inside, isa);
      expect_as_scalar(drop, leaving, RaySide::outside, isa);
      if (HasFatalFailure()) return;
    }
  }
}

TEST_F(WideIntersect, RaysThroughTheCentreMeetTheRadius) {
  for (const Isa isa : isas) {
    for (const DropInstant& drop : drops()) {
      for (const Eigen::Vector3d& u :
           {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1),
            Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.48, -0.6, 0.64)}) {
        const double r = surface_radius_m(drop, u), scale = drop.surface.scale;
        const DropRay in = {drop.origin_m + 5 * scale * u, -u}, out = {drop.origin_m, u};
        const auto met = intersect_drop_of(drop, {{in, {in.origin_m, u}}}, RaySide::outside, isa);
        ASSERT_TRUE(met[0]);
        EXPECT_NEAR(met[0]->distance / scale, 5 - r / scale, 1e-14);
        EXPECT_FALSE(met[1]) << "away from the drop";
        const auto left = intersect_drop_of(drop, {{out}}, RaySide::inside, isa);
        ASSERT_TRUE(left[0]);
        EXPECT_NEAR(left[0]->distance / scale, r / scale, 1e-14);
      }
    }
  }
}

TEST_F(WideIntersect, ARayGetsTheSameBytesInAnyCompanyAndOnAnyWideSet) {
  Random random(2);
  const DropInstant drop = concave_drop();
  const auto rays = outer_rays(drop, random, 203);
  const auto reference = intersect_drop_of(drop, rays, RaySide::outside, isas.front());
  for (const Isa isa : isas) {
    for (std::size_t first = 0; first < 11; ++first) {
      const auto hits =
          intersect_drop_of(drop, std::span(rays).subspan(first), RaySide::outside, isa);
      for (std::size_t i = 0; i < hits.size(); ++i) {
        ASSERT_EQ(hits[i].has_value(), reference[first + i].has_value());
        if (!hits[i]) continue;
        ASSERT_TRUE(same_bits(hits[i]->position, reference[first + i]->position)) << first + i;
        ASSERT_TRUE(same_bits(hits[i]->normal, reference[first + i]->normal)) << first + i;
      }
    }
  }
}

TEST_F(WideIntersect, AWalkThatCannotEndIsAnError) {
  // Steps of 2 G' / M = 2e-7 rad at most: 10000 of them do not cross the drop.
  DropInstant drop = frozen_drop({});
  drop.bound_bend = 1e7;
  const DropRay ray = {{-1e-3, 0, 0}, {1, 0, 0}};
  EXPECT_THROW(intersect_drop(drop, ray.origin_m, ray.direction, RaySide::inside),
               std::logic_error);
  for (const Isa isa : isas) {
    EXPECT_THROW(intersect_drop_of(drop, {{ray}}, RaySide::inside, isa), std::logic_error);
  }
}

TEST_F(WideIntersect, NoRaysGiveNoHits) {
  for (const Isa isa : isas) {
    EXPECT_TRUE(intersect_drop_of(concave_drop(), {}, RaySide::outside, isa).empty());
    EXPECT_TRUE(surface_points_of(concave_drop(), {}, {1, 0, 0}, isa).empty());
  }
}

TEST_F(WideIntersect, SurfacePointsAreSeenAndHiddenAsByTheScalarWalk) {
  Random random(3);
  for (const DropInstant& drop : drops()) {
    const Eigen::Vector3d to_camera = random_direction(random);
    std::vector<Eigen::Vector3d> directions = {{0, 0, 1}, {0, 0, -1}, to_camera, -to_camera};
    for (int i = 0; i < 1999; ++i) directions.push_back(random_direction(random));
    const auto expected = surface_points_of(drop, directions, to_camera, Isa::scalar);
    for (const Isa isa : isas) {
      const auto points = surface_points_of(drop, directions, to_camera, isa);
      for (std::size_t i = 0; i < points.size(); ++i) {
        // One evaluation of a polynomial of degree 10 at most, and its slope: some roundings.
        ASSERT_LT((points[i].position_m - expected[i].position_m).norm() / drop.surface.scale,
                  1e-14);
        ASSERT_LT((points[i].normal - expected[i].normal).norm(), 1e-13);
        ASSERT_EQ(points[i].hidden, expected[i].hidden) << isa_name(isa) << ", point " << i;
      }
    }
  }
}

}  // namespace
}  // namespace pluvia
