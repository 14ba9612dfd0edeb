#include "raytrace/reference_picture.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/reference_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

ReferenceSums traced(const ReferenceScene& scene, int passes, std::uint64_t seed = 1,
                     double samples_per_px = 4) {
  ReferenceSums sums = empty_sums(scene);
  trace_reference(scene,
                  {.error = 1e-9,
                   .learning_passes = 3,
                   .most_passes = passes,
                   .samples_per_px = samples_per_px,
                   .seed = seed},
                  sums);
  return sums;
}

// A sky of two halves and a lamp, and a drop of an oscillating set before it.
Scene small_scene(const Eigen::Vector3d& at_m = {0, 0, 0}) {
  Scene scene = dark_scene(16, 24, at_m);
  scene.environment.uniform_cd_m2 = {0.5, 0.6, 0.7};
  scene.lights = {{.name = "lamp",
                   .position_m = at_m + Eigen::Vector3d(0.3, 4, 1),
                   .intensity_cd = {60, 40, 20}}};
  return scene;
}

std::vector<Drop> two_drops(const Scene& scene) {
  return {falling_drop(scene, {0, 1, 0.09}, {0, 0, -8.49}, 3),
          falling_drop(scene, {0.02, 1.6, 0.11}, {0.5, 0, -8.49}, 7)};
}

// Of a sphere's image: its outline on the plane one focal length away is an ellipse of half axes
// f r / sqrt(z^2 - r^2) and f r sqrt(d^2 - r^2) / (z^2 - r^2), z its depth, d its distance.
double image_px2(double focal_px, double r, const Eigen::Vector3d& centre_m) {
  const double z2 = centre_m.y() * centre_m.y() - r * r;
  return pi * std::pow(focal_px * r, 2) * std::sqrt(centre_m.squaredNorm() - r * r) /
         std::pow(z2, 1.5);
}

TEST(ReferencePicture, AFallingSphereCoversItsImageTimesTheTimeThatItFalls) {
  // Within 4 standard errors of the 12 passes (Student's t: 0.2 % of seeds fail for each of three),
  // and the comparison is sharp to 0.5 %.
  const Eigen::Vector3d start(0.03, 0.8, 0.06), velocity(0.3, 1, -6);
  for (const auto& [hit_time_s, at_m] : {std::pair(1e27, Eigen::Vector3d(0, 0, 0)),
                                         {0.008, Eigen::Vector3d(0, 0, 0)},
                                         {1e27, Eigen::Vector3d(9000, -4000, 100)}}) {
    Scene scene = dark_scene(32, 32, at_m);
    Drop drop = falling_drop(scene, start, velocity);
    drop.hit_time_s = hit_time_s;
    const double end_s = std::min(hit_time_s, scene.camera.exposure_s);
    double expected = 0;
    for (int k = 0; k < 1000; ++k) {
      const Eigen::Vector3d centre = start + velocity * (end_s * (k + 0.5) / 1000);
      expected += image_px2(100, 1.6e-3, centre) / 1000 * end_s / scene.camera.exposure_s;
    }
    const auto made = reference_scene(scene, {drop});
    Sampled passes;
    for (std::uint64_t seed = 0; seed < 12; ++seed)
      passes.add(sum(traced(*made, 2, seed, 100).coverage) / 2);
    EXPECT_NEAR(passes.mean(), expected, 4 * passes.standard_error()) << "hit " << hit_time_s;
    EXPECT_LT(passes.standard_error(), 0.005 * expected);
  }
}

TEST(ReferencePicture, TheFurnaceShowsNoDropInAnyPixel) {
  // Every pixel is the environment, within 0.2 %: the noise of 20 passes is a tenth of that.
  Scene scene = dark_scene(12, 24);
  scene.environment.uniform_cd_m2 = {2, 2, 2};
  const auto made = reference_scene(scene, two_drops(scene));
  const ReferenceSums sums = traced(*made, 20);
  EXPECT_GT(*std::max_element(sums.coverage.begin(), sums.coverage.end()) / sums.passes, 0.004);
  for (std::size_t i = 0; i < sums.rain.size(); ++i)
    ASSERT_NEAR((sums.surface[i] + sums.rain[i]) / sums.passes, 2, 0.002 * 2) << "value " << i;
}

TEST(ReferencePicture, DropByDropIsWhatPlainCameraRaysSee) {
  // The second way: rays through every pixel at random times, whatever they meet. The sum of the
  // rain and each of its channels' largest rows, within 3 standard errors of both: three values,
  // one seed in 120 fails.
  Scene scene = dark_scene(6, 20);
  scene.camera.position_m = {0, 0, 0};
  scene.environment.uniform_cd_m2 = {0.5, 0.6, 0.7};
  scene.lights = small_scene().lights;
  // 5 cm drops in the open: large enough that plain rays meet them.
  const std::vector<Drop> drops = {falling_drop(scene, {0, 2, 0.15}, {0, 0, -8.49}, 3, 0.02),
                                   falling_drop(scene, {0.03, 3, 0.2}, {0, 0, -8.49}, 7, 0.02)};
  const auto made = reference_scene(scene, drops, {.cone_half_angle_rad = 0.3});
  const ReferenceSums sums = traced(*made, 40, 3);
  const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
  for (std::size_t c = 0; c < 3; ++c) {
    double ours = 0, variance = 0;
    for (std::size_t i = c; i < rain.mean.size(); i += 3) {
      ours += rain.mean[i];
      variance += rain.variance[i];
    }
    Sampled plain;
    for (std::uint64_t i = 0; i < 200000; ++i) {
      CounterRandom random({8, i});
      const Eigen::Vector2d place(6 * random.next(), 20 * random.next());
      const double time_s = scene.camera.exposure_s * random.next();
      const CameraSample sample = trace_camera_ray(*made, camera_ray(*made, place), time_s, random);
      const double change = sample.radiance[static_cast<Eigen::Index>(c)] -
                            scene.environment.uniform_cd_m2[static_cast<Eigen::Index>(c)];
      plain.add(120 * (sample.drop >= 0 ? change : 0));
    }
    // Pixels of a pass are not independent, neighbours share drops: their noise is added at most.
    EXPECT_NEAR(ours, plain.mean(), 3 * std::hypot(plain.standard_error(), std::sqrt(variance)))
        << "channel " << c;
    EXPECT_LT(plain.standard_error(), 0.05 * std::abs(plain.mean())) << "too blunt";
  }
}

TEST(ReferencePicture, TheSameBytesForOneThreadAndForTwo) {
  const Scene scene = small_scene();
  const auto made = reference_scene(scene, two_drops(scene));
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return traced(*made, 4);
  };
  const ReferenceSums one = with(1), two = with(2);
  EXPECT_EQ(one.rain, two.rain);
  EXPECT_EQ(one.rain_squares, two.rain_squares);
  EXPECT_EQ(one.surface, two.surface);
  EXPECT_EQ(one.samples, two.samples);
  EXPECT_GT(sum(one.coverage), 0);
  EXPECT_NE(one.rain, traced(*made, 4, 2).rain) << "another seed";
}

TEST(ReferencePicture, TheVarianceIsThatOfManySeeds) {
  // Of all pixels together: the mean over 50 seeds of the stated variance, against the variance of
  // the 50 pictures. Their ratio is 1 within about sqrt(2 / (50 x 30 pixels that count)) = 4 % for
  // normal errors; ours have tails, so 25 % is asked for. A variance off by the number of passes is
  // 800 % off.
  const Scene scene = small_scene();
  const auto made = reference_scene(scene, two_drops(scene));
  std::vector<Sampled> pictures(3 * 16 * 24);
  double stated = 0, spread = 0;
  constexpr int seeds = 50;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const ReferenceSums sums = traced(*made, 8, seed);
    const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
    stated += sum(rain.variance) / seeds;
    for (std::size_t i = 0; i < rain.mean.size(); ++i) pictures[i].add(rain.mean[i]);
  }
  for (const Sampled& pixel : pictures) spread += seeds * std::pow(pixel.standard_error(), 2);
  EXPECT_NEAR(stated / spread, 1, 0.25) << stated << " stated, " << spread << " found";
}

TEST(ReferencePicture, PixelsBrighterThanWhiteCountAsWhite) {
  // A relative error of such a pixel counts as the same error of a white one.
  Scene scene = dark_scene(2, 2);
  const std::vector<Drop> drop = {falling_drop(scene, {0, 1, 0})};
  for (const auto& [radiance, weight] : {std::pair(0.5, 1.0), {3.0, 1.0}, {12.0, 1.0 / 16}}) {
    scene.camera.white_cd_m2 = 3;
    scene.environment.uniform_cd_m2.setConstant(radiance);
    const auto made = reference_scene(scene, drop);
    EXPECT_NEAR(pixel_weights(*made, traced(*made, 2))[3], weight, 1e-12) << radiance;
  }
}

TEST(ReferencePicture, RainThatChangesNothingEndsToo) {
  // Under an even sky a drop is as bright as what is behind it: no signal for the noise to be held
  // against.
  Scene scene = dark_scene(16, 24);
  scene.environment.uniform_cd_m2 = {1, 1, 1};
  const auto made = reference_scene(scene, two_drops(scene));
  ReferenceSums sums = empty_sums(*made);
  trace_reference(*made, {.error = 0.1, .most_passes = 20000}, sums);
  const ReferenceErrors errors = estimated_errors(*made, sums);
  EXPECT_LT(sums.passes, 20000);
  EXPECT_GE(errors.rain, 1);
  EXPECT_LE(errors.rain_noise, 0.001);
  EXPECT_TRUE(meets(errors, 0.1));
  EXPECT_FALSE(meets(errors, 50 * errors.rain_noise));
  EXPECT_FALSE(meets({0.05, 0.5, 1e-9}, 0.1)) << "rain that can be told from none";
  EXPECT_FALSE(meets({0.2, 0.05, 1e-9}, 0.1)) << "the surfaces";
}

TEST(ReferencePicture, ItEndsAtTheErrorThatIsAskedFor) {
  const Scene scene = small_scene();
  const auto made = reference_scene(scene, two_drops(scene));
  int last = 0;
  for (const double error : {0.5, 0.1}) {
    ReferenceSums sums = empty_sums(*made);
    trace_reference(*made, {.error = error}, sums);
    EXPECT_LE(estimated_errors(*made, sums).rain, error);
    EXPECT_GE(sums.passes, 8);
    EXPECT_GE(sums.passes, last);
    last = sums.passes;
  }
  ReferenceSums none = empty_sums(*made);
  trace_reference(*made, {.budget_s = 1e-9}, none);
  EXPECT_EQ(none.passes, 0) << "no pass is begun after the budget";
}

}  // namespace
}  // namespace pluvia
