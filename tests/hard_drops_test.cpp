// Hard cases of the drop, the exposure and the picture: each streak stays finite, without negative
// light, and within a stated bound of an independent answer, or is refused with a reason.
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/streak_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr BruteOptions judge = {
    .replicates = 16, .instants = 32, .rays_per_instant = 600, .seed = 11};
const std::vector<LightDirection> lights = {{10, 150}, {-10, 140}, {30, 170}, {10, 170}};

double scattering_angle_rad(const LightDirection& light) {
  return std::acos(-std::cos(light.elevation_deg * pi / 180) *
                   std::cos(light.azimuth_deg * pi / 180));
}

// Against the closed form, for a drop that is a sphere all the time. One grid may be off by 2.7 %,
// since pieces are flat when they bend by 2 % of the cone: the sides of what a cone lights bulge by
// 2 / 3 of that on the mean, and an area by twice as much. The grids are turned and shifted
// independently.
void expect_a_sphere(const StreakRequest& request, const TracedStreak& streak, int grids) {
  expect_sound(request, streak);
  const double bound = 2 * 0.02 * 2 / 3 / std::sqrt(grids);
  for (std::size_t k = 0; k < request.lights.size(); ++k) {
    const double expected = sphere_intensity_in_cone(
        1.333, 3, scattering_angle_rad(request.lights[k]), request.cone_half_angle_rad);
    EXPECT_NEAR(disc_flux(streak, k) / expected, 1, bound) << "light " << k;
  }
}

std::string refusal_of(const StreakRequest& request) {
  try {
    trace_streak(request);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(HardDrops, AmplitudesOfZeroAreTheSphere) {
  const StreakRequest request = few_rows(1.6e-3, published_modes(0, 0), lights);
  expect_a_sphere(request, trace_streak(request), 16);
}

TEST(HardDrops, AmplitudesOfAMillionthAreTheSphereToo) {
  // Traced as an oscillating drop, over spans and slices: the other road to the same answer. Two
  // periods of mode 3 are eight spans of each replicate.
  StreakRequest request = few_rows(1.6e-3, published_modes(1e-6, -1e-6), lights);
  request.spans_per_period = 4;
  expect_a_sphere(request, trace_streak(request), 16);
}

TEST(HardDrops, AmplitudesThatTearTheDropAreRefused) {
  const std::string reason = refusal_of(few_rows(1.6e-3, published_modes(0.4, 0.4), lights));
  EXPECT_THAT(reason, testing::HasSubstr("the drop's surface comes as near as"));
  EXPECT_THAT(reason, testing::HasSubstr("expected more than 0.2 r0"));
}

TEST(HardDrops, StronglyConcaveDropAgreesWithBruteForce) {
  const StreakRequest request = few_rows(1.6e-3, published_modes(0.3, 0.2), lights);
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  expect_brute_force_agrees(request, streak, judge);
}

TEST(HardDrops, ManyPeriodsOfATinyDropAgreeWithBruteForce) {
  // r0 = 0.05 mm: 181 periods of mode 2 in 1/60 s.
  StreakRequest request = few_rows(0.05e-3, published_modes(0.11, 0), lights);
  EXPECT_NEAR(mode_frequency_rad_s(request.drop, 2) * request.exposure_s / (2 * pi), 181, 0.5);
  request.spans_per_period = 3;
  request.slices = 1500;
  request.field.base_cells = 8;
  request.field.space_depth = 0;
  request.field.time_depth = 0;
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  expect_brute_force_agrees(request, streak, judge);
}

TEST(HardDrops, AQuarterPeriodOfALargeDropAgreesWithBruteForce) {
  // r0 = 4 mm: 0.25 periods of mode 2 in 1/60 s.
  StreakRequest request = few_rows(4e-3, published_modes(0.19, 0.095), lights);
  request.spans_per_period = 48;
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  expect_brute_force_agrees(request, streak, judge);
}

TEST(HardDrops, ModesOfDegreeEightAgreeWithBruteForce) {
  // P_{8,5} reaches 2e5 and P_{8,8} 2e6: amplitudes of some per cent of r0 all the same.
  StreakRequest request =
      few_rows(1.6e-3, {{8, 0, 0.03, 1}, {8, 5, 1e-7, 2}, {8, 8, 1e-8, 0}}, lights);
  request.exposure_s = 2e-3;
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  expect_brute_force_agrees(request, streak, judge);
}

TEST(HardDrops, ExposureOfAMicrosecondIsTheDropAtShutterOpen) {
  // All phases are zero: it is still the sphere.
  StreakRequest request = few_rows(1.6e-3, published_modes(0.3, 0.2), lights);
  request.exposure_s = 1e-6;
  request.frame.path_rows = 8.49 * 1e-6 / request.frame.pixel_m;
  request.slices = 1;
  expect_a_sphere(request, trace_streak(request), 2);
}

TEST(HardDrops, ExposureOfASecondAgreesWithBruteForce) {
  // 60 periods of mode 2. Coarser spans or a time depth of 0 would be too coarse for light 2: its
  // total reflection comes and goes.
  StreakRequest request = few_rows(1.6e-3, published_modes(0.11, 0), lights);
  request.exposure_s = 1;
  request.spans_per_period = 4;
  request.slices = 1000;
  request.field.base_cells = 8;
  request.field.space_depth = 1;
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  expect_brute_force_agrees(request, streak, judge);
}

TEST(HardDrops, PictureOnePixelWideHoldsTheSpheresLight) {
  StreakRequest request = few_rows(1.6e-3, {}, lights);
  request.frame = {.width_px = 1,
                   .height_px = 1,
                   .pixel_m = 1.6e-3 / drop_radius_px,
                   .centre_column = 0.5,
                   .path_top_row = 0,
                   .path_rows = 1};
  // What falls beside the single pixel is cut off; in a frame of 8 x 14 of the same pixels it is
  // kept: the same pixel in both pictures, to the float's rounding.
  StreakRequest wide = request;
  wide.frame.width_px = 9;
  wide.frame.height_px = 9;
  wide.frame.centre_column = 4.5;
  wide.frame.path_top_row = 4;
  const TracedStreak one = trace_streak(request), all = trace_streak(wide);
  expect_sound(request, one);
  expect_a_sphere(wide, all, 16);
  for (std::size_t k = 0; k < lights.size(); ++k) {
    EXPECT_NEAR(one.light[k].mean[0], all.light[k].mean[4 * 9 + 4], 1e-6f * one.light[k].mean[0]);
  }
  EXPECT_NEAR(one.coverage.mean[0], 1, 0.01) << "the drop covers the pixel all the time";
  // The whole drop in one pixel.
  request.frame.pixel_m = 16e-3;
  request.frame.path_top_row = 0.5;
  request.frame.path_rows = 0;
  const TracedStreak far = trace_streak(request);
  expect_sound(request, far);
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const double pixels = std::pow(10 * drop_radius_px, 2);
    EXPECT_NEAR(far.light[k].mean[0] * pixels / sum(all.light[k].mean), 1, 1e-5) << k;
  }
}

TEST(HardDrops, ViewAlongTheFallIsRoundForADropThatIs) {
  // Modes of order 0 only: seen along the axis, lights of one elevation differ only by how they
  // stand to the grid: five of the replicates' own estimates, and half a per cent.
  for (const int view : {-90, 90}) {
    StreakRequest request = few_rows(1.6e-3, published_modes(0.19, 0), {});
    for (const int azimuth : {0, 37, 90, 180}) {
      request.lights.push_back({-2 * view / 3, azimuth});
    }
    request.view_elevation_deg = view;
    request.frame.path_rows = 0;
    const TracedStreak streak = trace_streak(request);
    expect_sound(request, streak);
    const double first = sum(streak.light[0].mean);
    for (std::size_t k = 1; k < 4; ++k) {
      const double error = std::sqrt(sum(streak.light[0].variance) + sum(streak.light[k].variance));
      EXPECT_NEAR(sum(streak.light[k].mean), first, 5 * error + 0.005 * first) << view << ", " << k;
    }
    expect_brute_force_agrees(request, streak, judge);
  }
}

}  // namespace
}  // namespace pluvia
