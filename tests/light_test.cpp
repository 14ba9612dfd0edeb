#include "raytrace/light.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace pluvia {
namespace {

Light spot() {
  Light light{"spot", {1, 2, 3}, {90, 60, 30}, LightKind::spot};
  light.direction = Eigen::Vector3d(0.6, 0, -0.8);
  light.inner_half_angle_deg = 20;
  light.outer_half_angle_deg = 50;
  return light;
}

TEST(Light, APointLightFallsOffWithTheSquareOfTheDistance) {
  const Light light{"lamp", {1, 2, 3}, {90, 60, 30}};
  for (const double d : {0.5, 2.0, 1000.0}) {
    const Eigen::Vector3d away = Eigen::Vector3d(1, -2, 2) / 3;
    const Illumination lit = illumination(light, light.position_m + d * away);
    EXPECT_NEAR(lit.distance_m, d, 1e-12 * d);
    EXPECT_LT((lit.toward + away).norm(), 1e-12);
    EXPECT_LT((lit.lux - light.intensity_cd / (d * d)).norm(), 1e-9);
  }
}

TEST(Light, NothingGrowsWithoutBoundAtALampsCentre) {
  Light light{"lamp", {1, 2, 3}, {9, 6, 3}};
  Illumination lit = illumination(light, light.position_m);
  EXPECT_EQ(lit.toward, Eigen::Vector3d(0, 0, 1));
  EXPECT_LT((lit.lux - light.intensity_cd * 1e6).norm(), 1e-3);  // as at 1 mm
  light.radius_m = 0.1;
  lit = illumination(light, light.position_m + Eigen::Vector3d(0.03, 0, 0));
  EXPECT_LT((lit.lux - light.intensity_cd * 100).norm(), 1e-9);
  EXPECT_TRUE(inside_lamp(light, lit, 1e-3));
  const auto beside = [&](double d) {
    return inside_lamp(light, illumination(light, light.position_m + Eigen::Vector3d(d, 0, 0)),
                       1e-3);
  };
  EXPECT_TRUE(beside(0.1009));
  EXPECT_FALSE(beside(0.1011));
}

TEST(Light, ASpotIsFullInsideNothingOutsideAndSmoothBetween) {
  const Light light = spot();
  const Eigen::Vector3d across = light.direction.unitOrthogonal();
  const auto share = [&](double angle_deg) {
    const double a = angle_deg * std::numbers::pi / 180;
    const Eigen::Vector3d at =
        light.position_m + 2 * (std::cos(a) * light.direction + std::sin(a) * across);
    return illumination(light, at).lux.x() / (90.0 / 4);
  };
  EXPECT_NEAR(share(0), 1, 1e-12);
  EXPECT_NEAR(share(19.9), 1, 1e-12);
  EXPECT_EQ(share(50.1), 0);
  EXPECT_EQ(share(180), 0);
  const auto cosine = [](double deg) { return std::cos(deg * std::numbers::pi / 180); };
  const double t = (cosine(35) - cosine(50)) / (cosine(20) - cosine(50));
  EXPECT_NEAR(share(35), t * t, 1e-12);
}

TEST(Light, ASpotWithASharpEdgeIsFinite) {
  Light light = spot();
  light.inner_half_angle_deg = light.outer_half_angle_deg;
  for (const double x : {0.0, 0.3, 1.0, 5.0})
    EXPECT_TRUE(illumination(light, {x, 2, 0}).lux.allFinite()) << x;
}

TEST(Light, TheSunShinesAlikeEverywhere) {
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(1, 2, -2) / 3;
  sun.illuminance_lux = {8e4, 7e4, 6e4};
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1e6, -5, 3)}) {
    const Illumination lit = illumination(sun, at);
    EXPECT_EQ(lit.toward, -sun.direction);
    EXPECT_EQ(lit.lux, sun.illuminance_lux);
    EXPECT_EQ(lit.distance_m, std::numeric_limits<double>::infinity());
    EXPECT_FALSE(inside_lamp(sun, lit, 1));
  }
}

}  // namespace
}  // namespace pluvia
