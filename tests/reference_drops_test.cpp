#include "raytrace/reference_drops.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/reference_samples.h"

namespace pluvia {
namespace {

TEST(ReferenceDrops, EmbreeFindsWhateverTheDropItselfIsMetBy) {
  // 400 drops of ten sets in a cloud up to 50 m away, rays aimed near them at random times: the
  // first drop that a search through all of them finds is the one that Embree's boxes lead to.
  const Scene scene = dark_scene(16, 16, {8000, -6000, 120});
  std::vector<Drop> list;
  CounterRandom random({4});
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d at(2 * random.next() - 1, 1 + 49 * random.next(), random.next());
    list.push_back(falling_drop(scene, at, {1, -2, -8}, i % 10, 5e-4 + 1e-3 * random.next()));
    list.back().id = static_cast<std::uint64_t>(i);
  }
  const FallingDrops drops = moving_drops(scene, list, gn2006_preset());
  ASSERT_EQ(drops.drops.size(), 400u);
  const DropGeometry geometry(drops);
  int met = 0;
  for (int i = 0; i < 4000; ++i) {
    const FallingDrop& aim = drops.drops[static_cast<std::size_t>(i % 400)];
    Moment moment(drops, drops.exposure_s * random.next());
    const Eigen::Vector3d off(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5);
    const Ray ray = {{0, 0, 0},
                     (aim.centre_m + moment.time_s() * aim.velocity_m_s + 3e-3 * off).normalized()};
    int nearest = -1;
    double distance_m = 1e9;
    for (int k = 0; k < 400; ++k) {
      const auto hit = meet_drop(drops, k, ray, moment);
      if (!hit || hit->distance >= distance_m) continue;
      nearest = k;
      distance_m = hit->distance;
    }
    const auto found = geometry.nearest(ray, moment, 1e9, -1);
    ASSERT_EQ(found ? found->drop : -1, nearest) << "ray " << i;
    if (!found) continue;
    ++met;
    const auto other = geometry.nearest(ray, moment, 1e9, nearest);
    EXPECT_TRUE(!other || other->drop != nearest) << "a drop that is to be skipped";
    EXPECT_FALSE(geometry.nearest(ray, moment, 0.999 * distance_m, -1)) << "beyond the end";
  }
  EXPECT_GT(met, 1000);
}

TEST(ReferenceDrops, OneMillimetreAtFiftyMetresIsMetWithoutError) {
  // In double, from its own frame: the surface of a sphere is hit to 1e-12 of the distance.
  const Scene scene = dark_scene(16, 16, {1e4, 1e4, 1e3});
  const FallingDrops drops =
      moving_drops(scene, {falling_drop(scene, {3, 50, -2}, {0, 0, -4}, 0, 5e-4)}, gn2006_preset());
  const DropGeometry geometry(drops);
  Moment moment(drops, 0.01);
  // Relative to the camera the list's centre is what double leaves of 1e4 m: 2e-12.
  const Eigen::Vector3d centre = drops.drops[0].centre_m + 0.01 * drops.drops[0].velocity_m_s;
  EXPECT_LT((centre - Eigen::Vector3d(3, 50, -2.04)).norm(), 1e-11);
  for (const double b : {0.0, 0.5, 0.999, 1.001}) {
    const Eigen::Vector3d across = centre.unitOrthogonal();
    // Aimed so that the ray passes the centre at a distance of b radii.
    const double sine = b * 5e-4 / centre.norm();
    const Ray ray = {{0, 0, 0}, std::sqrt(1 - sine * sine) * centre.normalized() + sine * across};
    const auto met = geometry.nearest(ray, moment, 1e9, -1);
    ASSERT_EQ(met.has_value(), b < 1) << b;
    if (!met) continue;
    EXPECT_NEAR(met->hit.position.norm(), 5e-4, 1e-11);
  }
}

TEST(ReferenceDrops, ADropEndsWhereItHitsAndOnesInTheLensOrALampAreLeftOut) {
  Scene scene = dark_scene();
  scene.lights = {{.name = "ball", .position_m = {0, 5, 0}, .radius_m = 0.3}};
  Drop hits = falling_drop(scene, {0, 2, 0});
  hits.hit_time_s = 0.004;
  Drop gone = hits;
  gone.hit_time_s = -1;
  const FallingDrops drops = moving_drops(
      scene, {hits, gone, falling_drop(scene, {0, 0.05, 0.1}), falling_drop(scene, {0, 5, 0})},
      gn2006_preset());
  ASSERT_EQ(drops.drops.size(), 1u);
  for (const double time_s : {0.0039, 0.0041}) {
    Moment moment(drops, time_s);
    const Ray ray = {{0, 0, 0}, Eigen::Vector3d(0, 2, -8.49 * time_s).normalized()};
    EXPECT_EQ(meet_drop(drops, 0, ray, moment).has_value(), time_s < 0.004);
  }
}

}  // namespace
}  // namespace pluvia
