#include "raytrace/reference_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/reference_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double water_index = 1.333;

// All exits of `count` rays along -x that meet a drop, evenly over a disc of its reach: visits
// (ray, exit); a ray that misses has no exit. Returns the disc's area over pi r0^2.
template <typename Visit>
double shoot_at(const DropShape& shape, int count, int split_order, const Visit& visit,
                double index = water_index) {
  const DropInstant drop = drop_at(shape, 1e-3);
  const double reach_m = drop_reach_m(shape);
  for (int i = 0; i < count; ++i) {
    CounterRandom random({77, std::uint64_t(i)});
    const double b = reach_m * std::sqrt(random.next()), turn = 2 * pi * random.next();
    const Eigen::Vector3d origin(4 * reach_m, b * std::cos(turn), b * std::sin(turn));
    const Eigen::Vector3d along(-1, 0, 0);
    const auto hit = intersect_drop(drop, origin, along, RaySide::outside);
    if (!hit) continue;
    follow_drop(drop, *hit, unpolarised_beam(along), index, split_order, random,
                [&](const DropExit& exit) { visit(i, exit); });
  }
  return std::pow(reach_m / shape.mean_radius_m, 2);
}

struct ConeCase {
  int order;
  double angle_deg;  // scattering angle of the light, 0: from behind the drop
};

TEST(ReferenceTracer, SphereScattersEachOrderIntoConesAsTheClosedFormTells) {
  // 12 comparisons at 3 standard errors: a right tracer fails for one seed in 31; it is fixed.
  // split_order 3 follows all four orders, -1 chooses one way at each interface.
  const std::vector<ConeCase> cases = {{0, 20}, {0, 90}, {1, 10}, {1, 40}, {2, 150}, {3, 125}};
  const DropShape sphere = {.mean_radius_m = 1.6e-3};
  constexpr int rays = 300000;
  constexpr double cone = 10 * pi / 180;
  for (const int split_order : {3, -1}) {
    std::vector<std::vector<double>> value(cases.size(), std::vector<double>(rays, 0.0));
    const double disc = shoot_at(sphere, rays, split_order, [&](int ray, const DropExit& exit) {
      for (std::size_t k = 0; k < cases.size(); ++k) {
        const double a = cases[k].angle_deg * pi / 180;
        const Eigen::Vector3d toward(-std::cos(a), std::sin(a), 0);
        if (exit.order != cases[k].order || exit.beam.direction.dot(toward) < std::cos(cone))
          continue;
        value[k][static_cast<std::size_t>(ray)] +=
            power(exit.beam) / (pi * std::pow(std::sin(cone), 2));
      }
    });
    for (std::size_t k = 0; k < cases.size(); ++k) {
      Sampled sampled;
      for (const double v : value[k]) sampled.add(disc * v);
      const int p = cases[k].order;
      const double a = cases[k].angle_deg * pi / 180;
      const double expected = sphere_intensity_in_cone(water_index, p, a, cone) -
                              (p > 0 ? sphere_intensity_in_cone(water_index, p - 1, a, cone) : 0);
      EXPECT_NEAR(sampled.mean(), expected, 3 * sampled.standard_error())
          << "order " << p << " at " << cases[k].angle_deg << " deg, split order " << split_order;
      EXPECT_LT(sampled.standard_error(), 0.2 * expected) << "too blunt";
    }
  }
}

TEST(ReferenceTracer, EachOrderOfASphereCarriesItsShareOfTheLight) {
  // 10 comparisons at 3 standard errors: one seed in 37 fails; it is fixed.
  const DropShape sphere = {.mean_radius_m = 1.6e-3};
  constexpr int rays = 100000;
  for (const int split_order : {3, -1}) {
    std::vector<std::vector<double>> value(5, std::vector<double>(rays, 0.0));
    const double disc = shoot_at(sphere, rays, split_order, [&](int ray, const DropExit& exit) {
      if (exit.order < 5)
        value[static_cast<std::size_t>(exit.order)][static_cast<std::size_t>(ray)] +=
            power(exit.beam);
    });
    for (int p = 0; p < 5; ++p) {
      Sampled sampled;
      for (const double v : value[static_cast<std::size_t>(p)]) sampled.add(disc * v);
      EXPECT_NEAR(sampled.mean(), sphere_energy(water_index, p), 3 * sampled.standard_error())
          << "order " << p << ", split order " << split_order;
    }
  }
}

TEST(ReferenceTracer, NothingIsLostOfLightThatIsHeldForLong) {
  // A drop of glass (n = 2.4) that oscillates holds light by total reflection beyond order 20,
  // where beams begin to end at random. All of it comes out, within 3 standard errors (one seed in
  // 370 fails); the share that comes out beyond order 40 shows that the drop does hold it.
  const DropShape shape = drop_shape(gn2006_preset(), 9, 1.6e-3);
  constexpr int rays = 40000;
  std::vector<double> all(rays, 0.0);
  double late = 0;
  const double disc = shoot_at(
      shape, rays, 3,
      [&](int ray, const DropExit& exit) {
        all[static_cast<std::size_t>(ray)] += power(exit.beam);
        late += exit.order > 40 ? power(exit.beam) / rays : 0;
      },
      2.4);
  Sampled sampled;
  for (const double whole : all) {
    if (whole > 0) sampled.add(whole);  // what misses has none; a hit at least a reflection
  }
  EXPECT_NEAR(sampled.mean(), 1, 3 * sampled.standard_error());
  EXPECT_GT(disc * late, 10 * sampled.standard_error());
}

TEST(ReferenceTracer, ADropInAUniformEnvironmentIsInvisible) {
  // The furnace: what leaves by all orders is what came in, for a concave, oscillating drop, too.
  // Of 40,000 rays the mean is good to 2e-4 (printed when it fails), ten times below the bound.
  Scene scene = dark_scene();
  scene.environment.uniform_cd_m2 = {1, 2, 3};
  const auto made = reference_scene(scene, {falling_drop(scene, {0, 2, 0.05}, {0, 0, -8.49}, 9)});
  Sampled sampled;
  for (int i = 0; i < 40000; ++i) {
    CounterRandom random({5, std::uint64_t(i)});
    const double time_s = random.next() / 60;
    const Eigen::Vector3d centre(0, 2, 0.05 - 8.49 * time_s);
    const Eigen::Vector3d aim =
        centre + 1.2e-3 * Eigen::Vector3d(2 * random.next() - 1, 0, 2 * random.next() - 1);
    const CameraSample sample =
        trace_camera_ray(*made, {{0, 0, 0}, aim.normalized()}, time_s, random);
    if (sample.drop == 0) sampled.add(sample.radiance.y() / 2);
  }
  EXPECT_GT(sampled.count, 30000);
  EXPECT_NEAR(sampled.mean(), 1, 0.002) << "standard error " << sampled.standard_error();
  EXPECT_LT(sampled.standard_error(), 4e-4);
}

TEST(ReferenceTracer, ASphereShowsWhatIsBehindItUpsideDown) {
  // A sky that is bright in the upper half: through the lower half of a drop on the horizon one
  // looks up. At impact 0.6 the ray is turned by 2 (i - r) = 20 deg toward the axis; 6 % of its
  // power is reflected and 1 % goes other ways.
  Scene scene = dark_scene();
  const auto made = [&] {
    auto sky = reference_scene(scene, {falling_drop(scene, {0, 1, 0}, {0, 0, -1e-6})});
    sky->map.radiance = make_image(8, 4, 3);
    for (int x = 0; x < 8; ++x)
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < 2; ++y) sky->map.radiance.at(x, y, c) = 1;
    return sky;
  }();
  for (const double side : {-1.0, 1.0}) {
    CounterRandom random({9});
    const Eigen::Vector3d aim(0, 1, side * 0.6 * 1.6e-3);
    const CameraSample sample = trace_camera_ray(*made, {{0, 0, 0}, aim.normalized()}, 0, random);
    ASSERT_EQ(sample.drop, 0);
    EXPECT_NEAR(sample.radiance.x(), side < 0 ? 1 : 0, 0.3) << "impact " << 0.6 * side;
  }
}

}  // namespace
}  // namespace pluvia
