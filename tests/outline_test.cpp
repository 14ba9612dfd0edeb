// The silhouette of a drop, against closed forms and against a scan of the whole surface.
#include "oscillation/outline.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/drop_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Outline, OfASphereIsACircleFromEverySide) {
  const DropInstant sphere = frozen_drop({}, 1.6e-3);
  for (const double elevation : {-0.5 * pi, -0.3, 0.0, 1.2, 0.5 * pi}) {
    for (double theta = 0; theta < 6.3; theta += 0.7) {
      EXPECT_NEAR(outline_radius_m(sphere.surface, outline_ray(elevation, 0.4, theta)), 1.6e-3,
                  1e-17)
          << elevation << " " << theta;
    }
  }
}

TEST(Outline, SeenLevelOfAnAxisymmetricDropIsItsMeridian) {
  // Every point of a body of revolution is at least as far from the axis's picture in the meridian
  // across the view as anywhere else at its height, but the widest at a given ANGLE need not be in
  // it unless r cos psi falls away from psi = 0: it does for |A20| <= 0.2, where r(u) grows by at
  // most 3 A20 sin^2 psi / 2 while cos psi falls by sin^2 psi / 2.
  for (const double a20 : {-0.2, 0.15}) {
    const DropInstant drop = frozen_drop({{.n = 2, .m = 0, .amplitude = a20}});
    for (double theta = 0; theta < 6.3; theta += 0.3) {
      EXPECT_NEAR(outline_radius_m(drop.surface, outline_ray(0, 0, theta)),
                  surface_radius_m(drop, theta, 0.5 * pi), 1e-15)
          << a20 << " " << theta;
    }
  }
}

TEST(Outline, IsTheFarthestPointOfTheSurfaceBesideItsRay) {
  // A scan of the half-plane in steps of 1e-4 rad: the maximum lies at most 5e-5 from a sample,
  // where r cos psi is lower by N^2 / 2 (5e-5)^2 < 1.3e-7 of its size (N = 10), never higher.
  Random random(3);
  for (int trial = 0; trial < 60; ++trial) {
    const DropInstant drop = frozen_drop({{.n = 2, .m = 0, .amplitude = uniform(random, -0.3, 0.3)},
                                          {.n = 3, .m = 1, .amplitude = uniform(random, -0.2, 0.2)},
                                          {.n = 5, .m = 3, .amplitude = 2e-3}});
    const OutlineRay ray =
        outline_ray(uniform(random, -1.5, 1.5), uniform(random, -3, 3), uniform(random, 0, 6));
    double farthest = 0;
    for (double psi = -0.5 * pi; psi < 0.5 * pi; psi += 1e-4) {
      const Eigen::Vector3d u = std::cos(psi) * ray.across + std::sin(psi) * ray.to_camera;
      farthest = std::max(farthest, surface_radius_m(drop, u) * std::cos(psi));
    }
    const double found = outline_radius_m(drop.surface, ray);
    EXPECT_GE(found, farthest - 1e-17) << "trial " << trial;
    EXPECT_LE(found, farthest * (1 + 1.3e-7)) << "trial " << trial;
  }
}

TEST(Outline, IsTouchedByTheLineOfSight) {
  // At the silhouette the normal is at right angles to the line of sight, unless the outline has a
  // cusp; the direction is good to 1e-9 rad and the normal turns at most some ten times as fast.
  const DropInstant drop =
      frozen_drop({{.n = 2, .m = 0, .amplitude = 0.1}, {.n = 3, .m = 1, .amplitude = 0.08}});
  for (double theta = 0; theta < 6.3; theta += 0.21) {
    const OutlineRay ray = outline_ray(0.4, 1.0, theta);
    const Eigen::Vector3d u = outline_direction(drop.surface, ray);
    // Along the half-plane only: its own slope vanishes there, not the whole gradient's.
    const Eigen::Vector3d side = ray.across.cross(ray.to_camera);
    const Eigen::Vector3d n = surface_normal(drop, u);
    const Eigen::Vector3d in_plane = n - n.dot(side) * side;
    EXPECT_NEAR(in_plane.dot(ray.to_camera), 0, 1e-8) << "theta " << theta;
  }
}

TEST(Outline, RightOfThePictureIsEastOfACameraInTheSouth) {
  // Camera on +x, level: up is +z, right +y (docs/fits.md).
  const OutlineRay right = outline_ray(0, 0, 0.5 * pi);
  EXPECT_LT((right.across - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((right.to_camera - Eigen::Vector3d(1, 0, 0)).norm(), 1e-15);
  const OutlineRay up = outline_ray(0.3, 0, 0);
  EXPECT_LT((up.across - Eigen::Vector3d(-std::sin(0.3), 0, std::cos(0.3))).norm(), 1e-15);
}

}  // namespace
}  // namespace pluvia
