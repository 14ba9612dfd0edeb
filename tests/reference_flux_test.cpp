// The reference against the two other ways to a streak's light: the exit field that the database is
// traced with, and the brute force that judges it. They share with it the surface of the drop and
// where a ray meets it; paths, polarisation and pictures are their own.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "raytrace/brute_force.h"
#include "tests/reference_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double distance_m = 40;  // rays to the drop are parallel within 1e-4

// A drop of a set, seen level by a camera far away, under a sun from that direction of its frame.
struct FluxCase {
  int oscillation;
  double elevation_deg, azimuth_deg;
};

struct Flux {  // m^2 / sr: integral of radiance over the picture, per lux; and m^2 covered
  double light = 0, light_error = 0;
  double coverage_m2 = 0;
};

// The drop's x is toward the camera at mid exposure (south), y image right: east.
Light sun(double elevation_deg, double azimuth_deg, const Eigen::Vector3d& illuminance_lux) {
  const double v = elevation_deg * pi / 180, h = azimuth_deg * pi / 180;
  const Eigen::Vector3d toward(std::cos(v) * std::sin(h), -std::cos(v) * std::cos(h), std::sin(v));
  return {.name = "sun",
          .kind = LightKind::sun,
          .direction = -toward,
          .illuminance_lux = illuminance_lux};
}

Flux reference_flux(const FluxCase& c) {
  Scene scene = dark_scene(4, 16);
  scene.lights = {sun(c.elevation_deg, c.azimuth_deg, {1, 1, 1})};
  const double half_path_m = 8.49 * scene.camera.exposure_s / 2;
  const auto made = reference_scene(
      scene, {falling_drop(scene, {0, distance_m, half_path_m}, {0, 0, -8.49}, c.oscillation)},
      {.cone_half_angle_rad = 5 * pi / 180});
  const double m2_per_px2 = std::pow(distance_m / made->frame.focal_px, 2);
  Sampled light, coverage;
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    ReferenceSums sums = empty_sums(*made);
    trace_reference(
        *made,
        {.error = 1e-9, .least_passes = 2, .most_passes = 2, .samples_per_px = 4e5, .seed = seed},
        sums);
    double rain = 0, covered = 0;
    for (std::size_t i = 0; i < sums.coverage.size(); ++i) {
      rain += sums.rain[3 * i + 1] / sums.passes;
      covered += sums.coverage[i] / sums.passes;
    }
    light.add(rain * m2_per_px2);
    coverage.add(covered * m2_per_px2);
  }
  return {light.mean(), light.standard_error(), coverage.mean()};
}

StreakRequest streak_request(const FluxCase& c) {
  const Preset& preset = gn2006_preset();
  StreakRequest request =
      shard_request(preset, {.diameter_um = 3200, .oscillation = c.oscillation});
  request.drop = drop_shape(preset, c.oscillation, 1.6e-3);
  request.lights = {{static_cast<int>(c.elevation_deg), static_cast<int>(c.azimuth_deg)}};
  request.field.paths.max_order = 6;  // the reference has all of them; beyond is below 1e-3
  request.slices = 96;
  request.field.space_depth = 2;
  request.field.time_depth = 1;
  return request;
}

double total(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum;
}

TEST(ReferenceFlux, AgreesWithBruteForceAndWithTheExitField) {
  // Against brute force within 3 standard errors of both, against the field within those and 1 % of
  // its own grid. Four comparisons at 3 standard errors of 16 replicates each (Student's t, both
  // sides): a right tracer fails for one seed in 60.
  for (const FluxCase& c : {FluxCase{3, 10, 150}, FluxCase{7, 10, 170}}) {
    const Flux ours = reference_flux(c);
    const StreakRequest request = streak_request(c);
    const double m2 = std::pow(request.frame.pixel_m, 2);
    const BruteStreak brute = brute_force_streak(
        request, {.replicates = 16, .instants = 48, .rays_per_instant = 1000, .seed = 3});
    const double error = std::hypot(ours.light_error, m2 * brute.flux[0].standard_error);
    EXPECT_NEAR(ours.light, m2 * brute.flux[0].mean, 3 * error) << "set " << c.oscillation;
    EXPECT_NEAR(ours.coverage_m2, m2 * brute.coverage_flux.mean, 0.005 * ours.coverage_m2);
    const double field = m2 * total(trace_streak(request).light[0].mean);
    EXPECT_NEAR(ours.light, field, 3 * ours.light_error + 0.01 * field) << "set " << c.oscillation;
    EXPECT_LT(error, 0.03 * ours.light) << "too blunt: " << ours.light_error << " of ours";
  }
}

// Relative, of the blue light of a streak, from the spread of seeds.
double error_of_blue(const std::vector<Light>& lights) {
  Scene scene = dark_scene(4, 16);
  scene.lights = lights;
  const double half_path_m = 8.49 * scene.camera.exposure_s / 2;
  const auto made =
      reference_scene(scene, {falling_drop(scene, {0, distance_m, half_path_m}, {0, 0, -8.49}, 3)},
                      {.cone_half_angle_rad = 5 * pi / 180});
  Sampled blue;
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    ReferenceSums sums = empty_sums(*made);
    trace_reference(
        *made,
        {.error = 1e-9, .least_passes = 2, .most_passes = 2, .samples_per_px = 4e5, .seed = seed},
        sums);
    double rain = 0;
    for (std::size_t i = 2; i < sums.rain.size(); i += 3) rain += sums.rain[i];
    blue.add(rain);
  }
  return blue.standard_error() / blue.mean();
}

TEST(ReferenceFlux, FindsADimLightBesideABrightOneOfAnotherColour) {
  // The bright one takes half of what was learned: an error greater by the root of 2. The errors
  // are themselves known to 18 % (16 seeds): 3 of those of their ratio. One right tracer in 700
  // fails.
  const Light dim = sun(10, 150, {0, 0, 1});
  const double alone = error_of_blue({dim});
  const double beside = error_of_blue({dim, sun(10, 110, {1000, 1000, 0})});
  EXPECT_LT(beside, std::sqrt(2.0) * (1 + 3 * 0.26) * alone) << alone;
}

}  // namespace
}  // namespace pluvia
