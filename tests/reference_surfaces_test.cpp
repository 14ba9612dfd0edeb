// A scene without a drop: direct light on surfaces.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/reference_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
const Eigen::Vector3d albedo(0.8, 0.5, 0.2);

// Looks straight down onto a floor 2 m below.
Scene floor_scene(const Eigen::Vector3d& at_m = {0, 0, 0}) {
  Scene scene = dark_scene(32, 32, at_m);
  scene.camera.target_m = at_m + Eigen::Vector3d(0, 0, -1);
  scene.mesh = square(at_m + Eigen::Vector3d(0, 0, -2), {0, 0, 1}, 8,
                      {.base_color = albedo, .emission_cd_m2 = {0, 0, 0.25}});
  return scene;
}

Ray ray_to(const Eigen::Vector3d& place_m) {
  return {{0, 0, 0}, place_m.normalized()};
}

Eigen::Vector3d seen(const ReferenceScene& scene, const Eigen::Vector3d& place_m,
                     std::uint64_t seed = 1) {
  CounterRandom random({seed});
  return trace_camera_ray(scene, ray_to(place_m), 0, random).radiance;
}

// Triangles are in float: places are good to 1e-6 of the 3 m around them, cosines and 1 / r^2 to a
// few of that.
constexpr double float_error = 1e-5;

void expect_near(const Eigen::Vector3d& value, const Eigen::Vector3d& expected, double tolerance) {
  EXPECT_LT((value - expected).norm(), tolerance * expected.norm())
      << value.transpose() << " against " << expected.transpose();
}

TEST(ReferenceSurfaces, APlaneUnderAPointLightFollowsTheLawOfDistanceAndCosine) {
  // E = I h / r^3 for a light h above, at a distance r; L = emission + albedo (ambient + E / pi).
  Scene scene = floor_scene();
  scene.environment.uniform_cd_m2 = {0.1, 0.2, 0.3};
  scene.lights = {{.name = "lamp", .position_m = {1, 0, -0.5}, .intensity_cd = {10, 20, 30}}};
  const auto made = reference_scene(scene, {});
  for (const double x : {-1.0, 0.0, 0.7}) {
    const double r = std::hypot(1 - x, 1.5);
    const Eigen::Vector3d lux = Eigen::Vector3d(10, 20, 30) * 1.5 / (r * r * r);
    const Eigen::Vector3d expected = Eigen::Vector3d(0, 0, 0.25) +
                                     albedo.cwiseProduct(Eigen::Vector3d(0.1, 0.2, 0.3) + lux / pi);
    expect_near(seen(*made, {x, 0, -2}), expected, float_error);
  }
}

TEST(ReferenceSurfaces, ASunLightsByItsCosineAndASpotOnlyItsCone) {
  Scene scene = floor_scene();
  scene.mesh.materials[0].emission_cd_m2.setZero();
  scene.lights = {{.name = "sun",
                   .kind = LightKind::sun,
                   .direction = Eigen::Vector3d(0, 0.6, -0.8),
                   .illuminance_lux = {100, 100, 100}}};
  expect_near(seen(*reference_scene(scene, {}), {0.3, 0, -2}), albedo * 80 / pi, float_error);
  scene.lights = {{.name = "spot",
                   .position_m = {0, 0, -0.5},
                   .intensity_cd = {9, 9, 9},
                   .kind = LightKind::spot,
                   .inner_half_angle_deg = 20,
                   .outer_half_angle_deg = 30}};
  const auto made = reference_scene(scene, {});
  // Full inside 20 degrees, and between the rims t^2 with t = 1/2 half way between the cosines.
  const double half = std::acos((std::cos(pi / 9) + std::cos(pi / 6)) / 2);
  const auto plain = [](double angle) { return 9 / 2.25 * std::pow(std::cos(angle), 3) / pi; };
  for (const auto& [angle, share] : {std::pair(0.2, 1.0), {half, 0.25}, {0.6, 0.0}})
    EXPECT_NEAR(seen(*made, {1.5 * std::tan(angle), 0, -2}).x(), share * 0.8 * plain(angle), 1e-4);
}

TEST(ReferenceSurfaces, OnlyALightWithShadowIsStoppedUnlessAllAre) {
  // A roof over x > 0, 1 m above the floor: the light 1.5 m above it at x = -0.5 puts the edge of
  // the shade where the line through the roof's edge at x = 0 meets the floor: x = 1.
  Scene scene = floor_scene();
  scene.lights = {{.name = "lamp", .position_m = {-0.5, 3, -0.5}, .intensity_cd = {10, 10, 10}}};
  Mesh roof = square({2, 3, -1}, {0, 0, 1}, 2, {});
  for (const std::uint32_t index : roof.indices) scene.mesh.indices.push_back(4 + index);
  for (int k = 0; k < 4; ++k) {
    scene.mesh.positions_m.push_back(roof.positions_m[static_cast<std::size_t>(k)]);
    scene.mesh.normals.push_back(roof.normals[static_cast<std::size_t>(k)]);
  }
  scene.mesh.triangle_material = {0, 0, 0, 0};
  const auto lit = [&](double x, bool shadow, bool all) {
    scene.lights[0].shadow = shadow;
    const auto made = reference_scene(scene, {}, {.all_shadows = all});
    // From below the roof: the camera's own ray would stop at it.
    MetSurface point = {.position_m = {x, 3, -2}, .material = {.base_color = {1, 1, 1}}};
    CounterRandom random({1});
    return surface_radiance(*made, point, random).x() > 0;
  };
  EXPECT_TRUE(lit(0.9, true, false));
  EXPECT_TRUE(lit(0.999, true, false));
  EXPECT_FALSE(lit(1.001, true, false));
  EXPECT_TRUE(lit(1.001, false, false));
  EXPECT_FALSE(lit(1.001, false, true));
  EXPECT_TRUE(lit(0.999, false, true));
}

TEST(ReferenceSurfaces, ALampWithARadiusIsASphereWithASoftShade) {
  // The irradiance of a sphere of uniform radiance I / (pi r^2) above the horizon is I cos / d^2,
  // whatever its radius. 20,000 random places on it: within 3 standard errors, one seed in 370
  // fails.
  Scene scene = floor_scene();
  scene.mesh.materials[0].emission_cd_m2.setZero();
  scene.lights = {{.name = "ball",
                   .position_m = {0, 0, -0.5},
                   .intensity_cd = {10, 10, 10},
                   .radius_m = 0.6,
                   .shadow = true}};
  const auto made = reference_scene(scene, {});
  Sampled sampled;
  for (std::uint64_t i = 0; i < 20000; ++i) sampled.add(seen(*made, {1, 0, -2}, i).x());
  const double expected = 0.8 / pi * 10 * 1.5 / std::pow(std::hypot(1, 1.5), 3);
  EXPECT_NEAR(sampled.mean(), expected, 3 * sampled.standard_error());
  EXPECT_LT(sampled.standard_error(), 0.005 * expected);
}

TEST(ReferenceSurfaces, TenKilometresFromTheOriginIsAsGoodAsThere) {
  // Vertices are in float, in the scene already: at 1e4 m they lie on a grid of 1 mm, of 2 m away.
  const Eigen::Vector3d far(8192, -8192, 512);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0), far}) {
    Scene scene = floor_scene(at);
    scene.lights = {{.name = "lamp",
                     .position_m = at + Eigen::Vector3d(0, 0, -0.5),
                     .intensity_cd = {10, 10, 10},
                     .shadow = true}};
    const double expected = 0.8 / pi * 10 / 2.25;
    EXPECT_NEAR(seen(*reference_scene(scene, {}), {0, 0, -2}).x(), expected, 2e-3 * expected);
  }
}

TEST(ReferenceSurfaces, FogIsRefused) {
  Scene scene = dark_scene();
  scene.fog = Fog{};
  EXPECT_THROW(reference_scene(scene, {}), std::runtime_error);
}

}  // namespace
}  // namespace pluvia
