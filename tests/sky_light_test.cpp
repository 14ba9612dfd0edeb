#include "raytrace/sky_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/environment_map.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

Image random_map(int height) {
  std::mt19937 random(12);
  std::exponential_distribution<float> value(1);
  Image map = make_image(2 * height, height, 3);
  for (float& v : map.values) v = value(random);
  return map;
}

Eigen::Matrix3d some_rotation() {
  return Eigen::AngleAxisd(1.9, Eigen::Vector3d(0.4, -1, 0.7).normalized()).matrix();
}

TEST(TurningMatrix, AboutZIsTheClosedForm) {
  for (const int degree : {0, 1, 3, 8}) {
    const auto count = static_cast<Eigen::Index>(harmonic_count(degree));
    const Eigen::VectorXd c = Eigen::VectorXd::LinSpaced(count, -1, 2);
    const Eigen::MatrixXd m =
        turning_matrix(degree, Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).matrix());
    const auto wanted = turned_about_z({c.data(), static_cast<std::size_t>(count)}, 0.7);
    const Eigen::VectorXd turned = m * c;
    // 153 products of size 1 at most, each rounded some ten times.
    for (Eigen::Index i = 0; i < count; ++i)
      EXPECT_NEAR(turned[i], wanted[static_cast<std::size_t>(i)], 2e-13) << degree << " " << i;
  }
}

TEST(TurningMatrix, IsARotationAndRotationsFollowEachOther) {
  const Eigen::Matrix3d a = some_rotation();
  const Eigen::Matrix3d b =
      Eigen::AngleAxisd(-0.8, Eigen::Vector3d(1, 1, -0.3).normalized()).matrix();
  const int degree = highest_harmonic_degree;
  const Eigen::MatrixXd first = turning_matrix(degree, a), second = turning_matrix(degree, b);
  EXPECT_LT((first.transpose() * first - Eigen::MatrixXd::Identity(81, 81)).norm(), 1e-12);
  EXPECT_LT((second * first - turning_matrix(degree, b * a)).norm(), 1e-12);
  // Degrees do not mix: f of degree 1 stays so.
  EXPECT_LT(first.block(4, 1, 77, 3).norm(), 1e-12);
}

TEST(TurningMatrix, OfALinearFunctionTurnsItsDirection) {
  // sqrt(4 pi / 3) (y, z, x) are the harmonics of degree 1: f = d . v has coefficients v.
  const Eigen::Vector3d v(0.3, -0.5, 0.9), turned = some_rotation() * v;
  const Eigen::Vector4d c(0, v.y(), v.z(), v.x());
  const Eigen::VectorXd found = turning_matrix(1, some_rotation()) * c;
  EXPECT_NEAR(found[1], turned.y(), 1e-14);
  EXPECT_NEAR(found[2], turned.z(), 1e-14);
  EXPECT_NEAR(found[3], turned.x(), 1e-14);
}

TEST(SkyLight, SeenFromAFrameIsTheMapProjectedThere) {
  // The projection's own error at degree 3: pieces of pi / 64 at two Gauss points, (4 pi / 64)^4 /
  // 4320 = 3.4e-7 of the largest coefficient, here sqrt(4 pi).
  const Image map = random_map(32);
  const EnvironmentLight light = {.map_file = "map", .scale_cd_m2 = 2};
  const SkyLight seen = seen_from(sky_light(light, &map, 3), some_rotation());
  const auto brute = harmonic_coefficients({map, some_rotation()}, 3);
  ASSERT_EQ(seen.coefficients.rows(), 16);
  for (Eigen::Index i = 0; i < 16; ++i) {
    for (Eigen::Index c = 0; c < 3; ++c)
      EXPECT_NEAR(seen.coefficients(i, c),
                  2 * brute[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)], 2 * 1.2e-6)
          << i << " " << c;
  }
}

TEST(SkyLight, TurnedOverIsTheMapUpsideDown) {
  const Image map = random_map(32);
  Image upside_down = map;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c) upside_down.at(x, y, c) = map.at(x, map.height - 1 - y, c);
    }
  }
  const EnvironmentLight light = {.map_file = "map"};
  const SkyLight over = turned_over(sky_light(light, &map, 3));
  EXPECT_LT((over.coefficients - sky_light(light, &upside_down, 3).coefficients).norm(), 1e-11);
  EXPECT_GT((over.coefficients - sky_light(light, &map, 3).coefficients).norm(), 0.01);
}

TEST(SkyLight, AGreyMapIsUniform) {
  Image map = make_image(64, 32, 3);
  std::fill(map.values.begin(), map.values.end(), 0.5f);
  const EnvironmentLight light = {.map_file = "map", .scale_cd_m2 = 6};
  const SkyLight sky = sky_light(light, &map, 3);
  EXPECT_EQ(degree_of(sky), 0);
  EXPECT_NEAR(mean_radiance(sky).y(), 3, 3e-6);
  const SkyLight uniform = sky_light({.uniform_cd_m2 = {3, 2, 1}}, nullptr, 3);
  EXPECT_EQ(degree_of(uniform), 0);
  EXPECT_LT((mean_radiance(uniform) - Eigen::Vector3d(3, 2, 1)).norm(), 1e-15);
  EXPECT_EQ(degree_of(SkyLight{}), 0);
}

TEST(SkyLight, EndsAtTheDegreeThatTheMapHas) {
  // L = 1 + z / 2: degree 1, with c_10 = sqrt(4 pi / 3) / 2. Pixels of side h hold their centre's
  // value for all of them: off by less than h^2, 0.0024, of it, and none of it of degree 3 for the
  // map is odd about the horizon; degree 2, even, has no share either.
  Image map = make_image(128, 64, 3);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 128; ++x) {
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) = static_cast<float>(1 + map_direction(map, x + 0.5, y + 0.5).z() / 2);
    }
  }
  const EnvironmentLight light = {.map_file = "map"};
  const SkyLight two = sky_light(light, &map, 2);
  EXPECT_EQ(degree_of(two), 1);
  EXPECT_NEAR(two.coefficients(2, 0), std::sqrt(4 * pi / 3) / 2, 0.0024);
  EXPECT_NEAR(mean_radiance(two).x(), 1, 1e-6);
  EXPECT_EQ(degree_of(sky_light(light, &map, 0)), 0);
  EXPECT_NEAR(mean_radiance(sky_light(light, &map, 0)).x(), 1, 1e-6);
}

}  // namespace
}  // namespace pluvia
