// Splashes are where the rain's drops hit, and nowhere else.
#include "raytrace/splash_space.h"

#include <algorithm>
#include <cmath>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

const std::string scenes = PLUVIA_SOURCE_DIR "/data/scenes/";

// The splash at a place, or nullptr.
const Splash* find_splash(const std::vector<Splash>& splashes, const Eigen::Vector3d& place_m,
                          double since_s) {
  for (const Splash& splash : splashes) {
    if ((splash.place_m - place_m).norm() < 1e-5 && std::abs(splash.since_s - since_s) < 1e-5)
      return &splash;
  }
  return nullptr;
}

// A box of rain around the camera over a plane that leans a little.
Scene leaning_scene(const Eigen::Vector3d& velocity_m_s) {
  Scene scene;
  scene.camera.position_m = {0.3, -0.4, 1.6};
  scene.mesh.positions_m = {{-30, -30, -0.4f}, {30, -30, 5.6f}, {30, 30, 8.6f}, {-30, 30, 2.6f}};
  scene.mesh.indices = {0, 1, 2, 0, 2, 3};
  scene.rain.box_min_m = {-6, -6, -9};
  scene.rain.box_max_m = {6, 12, 7};
  scene.rain.culling_radius_m = 20;  // all of the box
  scene.rain.local_height_m = 7.5;
  scene.rain.sizes = {{.r0_m = 1.6e-3, .drops_per_m3 = 3, .velocity_m_s = velocity_m_s}};
  return scene;
}

TEST(SplashSpace, ADropThatHitsIsASplashWhereAndWhenItHit) {
  for (const Eigen::Vector3d& velocity : {Eigen::Vector3d(0, 0, -8.49), {3, -2, -8}}) {
    Scene scene = leaning_scene(velocity);
    const RainSpace space = make_rain_space(scene);
    const SplashSpace splashes = make_splash_space(scene, space);
    const double duration_s = splashes.duration_s[0];
    ASSERT_GT(duration_s, 0.1);
    // Across the wrap of the local height (7.5 m at 8.5 m/s: 0.88 s), and with the camera
    // elsewhere.
    long hits = 0;
    for (const double time_s : {0.0, 0.7, 0.85, 1.6, 86400.3}) {
      scene.camera.position_m = {0.3, -0.4, 1.6};
      const std::vector<Drop> drops = drop_field(scene, space, 10, time_s);
      for (const double later_s : {0.02, 0.5 * duration_s, 0.98 * duration_s}) {
        scene.camera.position_m = {0.3, -0.4, 1.6 + 0.2 * later_s};
        const auto found = splash_field(scene, space, splashes, time_s + later_s);
        for (const Drop& drop : drops) {
          if (!(drop.hit_time_s > 0 && drop.hit_time_s < later_s)) continue;
          const Eigen::Vector3d place = drop.centre_m + drop.hit_time_s * drop.velocity_m_s;
          EXPECT_TRUE(find_splash(found, place, later_s - drop.hit_time_s))
              << place.transpose() << " at " << time_s << " + " << later_s;
          ++hits;
        }
      }
    }
    EXPECT_GT(hits, 1000);
  }
}

TEST(SplashSpace, ThereAreAsManySplashesAsHits) {
  for (const Eigen::Vector3d& velocity : {Eigen::Vector3d(0, 0, -8.49), {3, -2, -8}}) {
    Scene scene = leaning_scene(velocity);
    const RainSpace space = make_rain_space(scene);
    const SplashSpace splashes = make_splash_space(scene, space);
    double count = 0;
    constexpr int times = 20;
    for (int i = 0; i < times; ++i)
      count += static_cast<double>(splash_field(scene, space, splashes, 3.7 * i).size()) / times;
    // Through the part of the box above the surface; along a slanted fall what comes in from above
    // and from the sides. Straight down: density x area x speed x time.
    const double seconds = splashes.duration_s[0] + scene.camera.exposure_s;
    const double straight = 3 * 12 * 18 * -velocity.z() * seconds;
    const double tilt = velocity.x() == 0 ? 0 : 0.35;  // the surface faces the wind or turns away
    // The cells keep their numbers of drops for ever: Poisson's spread of one local height's.
    EXPECT_NEAR(count / straight, 1, tilt + 4 / std::sqrt(3 * 12 * 18 * 7.5)) << count;
  }
}

TEST(SplashSpace, EverySplashLiesOnTheHighestSurface) {
  Scene scene = leaning_scene({3, -2, -8});
  const RainSpace space = make_rain_space(scene);
  const SplashSpace splashes = make_splash_space(scene, space);
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.1, -0.05, 1).normalized();
  for (const Splash& splash : splash_field(scene, space, splashes, 2)) {
    EXPECT_NEAR(normal.dot(splash.place_m - Eigen::Vector3d(-30, -30, -0.4)), 0, 1e-5);
    EXPECT_LT((splash.normal - normal).norm(), 1e-5);
  }
}

TEST(SplashSpace, SmallDropsAndBareAirHaveNone) {
  Scene scene = leaning_scene({0, 0, -4});
  scene.rain.sizes[0].r0_m = 0.5e-3;
  RainSpace space = make_rain_space(scene);
  EXPECT_TRUE(splash_field(scene, space, make_splash_space(scene, space), 1).empty());
  scene.rain.sizes.clear();
  scene.drops = {{.centre_m = {0, 3, 5}, .r0_m = 0.5e-3, .velocity_m_s = {0, 0, -4}}};
  space = make_rain_space(scene);
  for (double time_s = 0; time_s < 1; time_s += 0.01)
    EXPECT_TRUE(splash_field(scene, space, make_splash_space(scene, space), time_s).empty());
  scene = leaning_scene({0, 0, -8.49});
  scene.mesh = {};
  space = make_rain_space(scene);
  EXPECT_TRUE(splash_field(scene, space, make_splash_space(scene, space), 1).empty());
}

TEST(SplashSpace, NoneIsUnderARoof) {
  Scene scene = read_scene(scenes + "passages.toml");
  const RainSpace space = make_rain_space(scene);
  const SplashSpace splashes = make_splash_space(scene, space);
  long covered = 0, open = 0, high = 0;
  for (const double time_s : {0.0, 3.0, 6.0}) {
    scene.camera = camera_at(scene, time_s);
    for (const Splash& splash : splash_field(scene, space, splashes, time_s)) {
      // The passage of block.gltf: 3 m wide, 3.4 m high, between the court and the street.
      const Eigen::Vector3d& p = splash.place_m;
      const bool inside = std::abs(p.x()) < 1.4 && p.y() > 7 && p.y() < 15;
      covered += inside && p.z() < 3;
      high += inside && p.z() > 3;
      open += std::abs(p.x()) < 1.4 && p.y() > -3 && p.y() < 5 && p.z() < 0.5;
    }
  }
  EXPECT_EQ(covered, 0);
  EXPECT_GT(high, 30) << "on the roof";
  EXPECT_GT(open, 30) << "in the court";
}

TEST(SplashSpace, ASingleDropSplashesOnce) {
  Scene scene = leaning_scene({0, 0, -8.49});
  for (Eigen::Vector3f& p : scene.mesh.positions_m) p.z() = 0;
  scene.rain.sizes.clear();
  scene.drops = {{.centre_m = {1, 3, 0.849}}};
  const RainSpace space = make_rain_space(scene);
  const SplashSpace splashes = make_splash_space(scene, space);
  const auto at = [&](double time_s) { return splash_field(scene, space, splashes, time_s); };
  EXPECT_TRUE(at(0.08).empty());
  ASSERT_EQ(at(0.099).size(), 1u);
  EXPECT_NEAR(at(0.099)[0].since_s, -0.001, 1e-9);
  EXPECT_NEAR(at(0.2)[0].since_s, 0.1, 1e-9);
  EXPECT_LT((at(0.2)[0].place_m - Eigen::Vector3d(1, 3, 0)).norm(), 1e-9);
  EXPECT_TRUE(at(0.1 + splashes.duration_s[0] + 1e-6).empty());
}

}  // namespace
}  // namespace pluvia
