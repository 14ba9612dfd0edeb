#include "raytrace/streak_tracer.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/streak_samples.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double radius_m = 1.6e-3;

StreakRequest small_request(double a20, double a31) {
  StreakRequest request = forty_rows(radius_m, a20, a31);
  request.lights = {{10, 150}, {30, 50}, {-90, 170}, {90, 170}};
  return request;
}

TracedStreak trace_with(int threads, const StreakRequest& request) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  return trace_streak(request);
}

TEST(StreakTracer, SameBytesForOneThreadAndFour) {
  // Many short blocks that all meet in the same rows: the order of their additions shows.
  StreakRequest request = small_request(0.11, 0.1);
  request.slices = 240;
  request.field.base_cells = 4;
  request.field.space_depth = 0;
  request.frame.path_rows = 4;
  const TracedStreak one = trace_with(1, request), two = trace_with(4, request);
  const auto a = images_of(one), b = images_of(two);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k]->mean, b[k]->mean) << "image " << k;
    EXPECT_EQ(a[k]->variance, b[k]->variance) << "image " << k;
  }
  EXPECT_EQ(one.beyond_order, two.beyond_order);
  StreakRequest other = request;
  other.seed = 2;
  EXPECT_NE(trace_streak(other).light[0].mean, one.light[0].mean) << "the seed is not used";
}

std::string refusal_of(const StreakRequest& request) {
  try {
    trace_streak(request);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(StreakTracer, DropsThatNearlyTouchTheirCentreAreRefused) {
  EXPECT_THAT(refusal_of(small_request(0.4, 0.4)),
              testing::MatchesRegex("the drop's surface comes as near as .* r0 to its centre; "
                                    "expected more than 0.2 r0 .smaller amplitudes."));
  // With A20 alone the surface is nearest on the equator or at the poles: 1 - A at the poles when
  // the sine is -1. 0.79 leaves 0.21, 0.81 leaves 0.19.
  StreakRequest request = small_request(0.81, 0);
  request.slices = 1;
  EXPECT_THAT(refusal_of(request), testing::HasSubstr("as near as 0.1"));
  request = small_request(0.79, 0);
  request.slices = 1;
  EXPECT_EQ(refusal_of(request), "");
  EXPECT_EQ(refusal_of(small_request(std::nan(""), 0)),
            "amplitude nan of mode 2, 0; expected a finite number");
}

TEST(StreakTracer, RigidSphereReturnsTheEnergyOfItsOrders) {
  // Orders 0 to 3 of a sphere of index 1.333 return 0.99682 of a uniform environment (the sum of
  // data/tables/sphere_energy_fractions.csv); the bound is that of the report's furnace.
  StreakRequest request = small_request(0, 0);
  request.field.base_cells = 12;
  const TracedStreak streak = trace_streak(request);
  EXPECT_NEAR(sum(streak.env.mean) / sum(streak.coverage.mean), 0.99682, 5e-4);
  EXPECT_NEAR(streak.lost, 0, 1e-5);
}

// Sum of the coverage over the closed form, pi 5.6^2 pixels at every instant, less 1.
double silhouette_error(const StreakRequest& request) {
  return sum(trace_streak(request).coverage.mean) / (pi * 5.6 * 5.6) - 1;
}

// The outline of a sphere is cut into N chords, which leave out (2 pi / N)^2 / 6 of its area, and a
// chord of a coarse cell beside the bulge of its refined neighbour leaves a crack of the same
// order. The coarse grids of these tests have N of about 50: 0.27 %.
constexpr double outline_error = 3.5e-3;

TEST(StreakTracer, CoverageOfASphereConvergesToItsSilhouette) {
  StreakRequest request = small_request(0, 0);
  const double coarse = silhouette_error(request);
  EXPECT_NEAR(coarse, 0, outline_error);
  EXPECT_LT(coarse, 0) << "chords lie inside";
  // Cells of half the size: a quarter of the error (a third leaves room for the dither).
  request.field.base_cells *= 2;
  EXPECT_NEAR(silhouette_error(request), 0, std::abs(coarse) / 3);
}

TEST(StreakTracer, RowsOfARigidDropInMidFallAreAllAlike) {
  const TracedStreak streak = trace_streak(small_request(0, 0));
  // Rows 18 to 46 are passed by the whole drop: centre from 12 to 52, 5.6 rows either way.
  for (const StreakImage* image : images_of(streak)) {
    for (int column = 0; column < 16; ++column) {
      const auto at = [&](int row) {
        return image->mean[static_cast<std::size_t>(row * 16 + column)];
      };
      for (int row = 19; row < 46; ++row) ASSERT_NEAR(at(row), at(18), 1e-5 * (at(18) + 1e-3f));
    }
  }
}

TEST(StreakTracer, CoverageOfASphereDoesNotDependOnTheView) {
  for (const double view : {-80.0, -30.0, 0.0, 60.0, 80.0, 90.0}) {
    StreakRequest request = small_request(0, 0);
    request.view_elevation_deg = view;
    request.frame.path_rows = 40 * std::cos(view * pi / 180);
    const TracedStreak streak = trace_streak(request);
    expect_sound(request, streak);
    EXPECT_NEAR(sum(streak.coverage.mean) / (pi * 5.6 * 5.6), 1, outline_error) << "view " << view;
  }
}

TEST(StreakTracer, MirroredDropUnderMirroredLightsIsTheMirroredStreak) {
  // Sets 2 and 4: phi_drop 90 and 270 degrees. The lights' azimuths are mirrored, too; the grids
  // are not, so the streaks agree to their own error only: five times the replicates' estimate of
  // both sums of squares.
  StreakRequest right = small_request(0.11, 0.1), left = right;
  right.drop.phi_drop_rad = pi / 2;
  left.drop.phi_drop_rad = 3 * pi / 2;
  for (LightDirection& light : left.lights) light.azimuth_deg = 360 - light.azimuth_deg;
  const TracedStreak a = trace_streak(right), b = trace_streak(left);
  const auto ours = images_of(a), theirs = images_of(b);
  for (std::size_t k = 0; k < ours.size(); ++k) {
    double straight = 0, mirrored = 0, noise = 0;
    for (std::size_t i = 0; i < ours[k]->mean.size(); ++i) {
      const std::size_t flipped = i / 16 * 16 + 15 - i % 16;
      mirrored += std::pow(ours[k]->mean[i] - theirs[k]->mean[flipped], 2);
      straight += std::pow(ours[k]->mean[i] - theirs[k]->mean[i], 2);
      noise += ours[k]->variance[i] + theirs[k]->variance[flipped];
    }
    EXPECT_LT(mirrored, 25 * noise) << "image " << k;
    EXPECT_GT(straight, 4 * mirrored) << "image " << k << " is symmetric: nothing was tested";
  }
}

TEST(StreakTracer, EstimatedVarianceCoversTheErrorOfTheFlux) {
  // Six lights under two seeds against a run of 16 times the work. The estimate from two replicates
  // has one degree of freedom, so single lights scatter; the sum of squared errors of all fluxes
  // may exceed the sum of their variances (the sums of pixels' variances, as if pixels were
  // independent) by 4^2.
  StreakRequest request = small_request(0.11, 0.1);
  request.lights = {{10, 150}, {-30, 130}, {10, 90}, {50, 170}, {70, 30}, {10, 170}};
  StreakRequest fine = request;
  fine.slices = 160;
  fine.spans_per_period = 8;
  fine.field.base_cells = 12;
  fine.field.space_depth = 2;
  fine.field.time_depth = 1;
  const TracedStreak truth = trace_streak(fine);
  double error = 0, estimate = 0;
  for (const std::uint64_t seed : {1, 2}) {
    request.seed = seed;
    const TracedStreak streak = trace_streak(request);
    for (std::size_t k = 0; k < request.lights.size(); ++k) {
      const double flux = sum(truth.light[k].mean);
      error += std::pow((sum(streak.light[k].mean) - flux) / flux, 2);
      estimate += sum(streak.light[k].variance) / (flux * flux);
    }
  }
  EXPECT_LT(std::sqrt(error), 4 * std::sqrt(estimate));
  // And it is no blank cheque: the true error is of the estimate's size.
  EXPECT_GT(std::sqrt(error), std::sqrt(estimate) / 10);
}

TEST(StreakTracer, PictureOneColumnWideHoldsTheSameLight) {
  StreakRequest wide = small_request(0.11, 0.1);
  wide.motion_tolerance = 0;  // as many slices, however large the pixels
  StreakRequest narrow = wide;
  narrow.frame.width_px = 1;
  narrow.frame.height_px = 4;
  narrow.frame.pixel_m *= 16;
  narrow.frame.centre_column = 0.5;
  narrow.frame.path_top_row /= 16;
  narrow.frame.path_rows /= 16;
  const TracedStreak a = trace_streak(wide), b = trace_streak(narrow);
  expect_sound(narrow, b);
  // Sums of light times area, the same but for the summation: 256 pixels to one.
  const auto ours = images_of(a), theirs = images_of(b);
  for (std::size_t k = 0; k < ours.size(); ++k) {
    EXPECT_NEAR(256 * sum(theirs[k]->mean) / sum(ours[k]->mean), 1, 1e-5) << "image " << k;
  }
}

TEST(StreakTracer, ExposureOfAMicrosecondFreezesTheDrop) {
  StreakRequest request = small_request(0.11, 0.1);
  request.exposure_s = 1e-6;
  request.frame.path_rows = 8.49 * 1e-6 / request.frame.pixel_m;  // 0.03 rows
  const TracedStreak streak = trace_streak(request);
  expect_sound(request, streak);
  // All phases start at zero: the drop is still the sphere.
  EXPECT_NEAR(sum(streak.coverage.mean) / (pi * 5.6 * 5.6), 1, outline_error);
}

TEST(StreakTracer, LightsAndViewsAtTheirLimitsGiveSoundPictures) {
  for (const double view : {-90.0, 0.0, 80.0, 90.0}) {
    StreakRequest request = small_request(0.19, 0.095);
    request.slices = 12;
    request.view_elevation_deg = view;
    request.lights = {{-90, 170}, {90, 170}, {-90, 0}, {0, 0}, {0, 180}};
    const TracedStreak streak = trace_streak(request);
    expect_sound(request, streak);
    // At +-90 the azimuth has no meaning: the directions differ by cos(90 degrees), 6e-17.
    EXPECT_NEAR(sum(streak.light[0].mean) / sum(streak.light[2].mean), 1, 1e-6) << "view " << view;
  }
}

TEST(StreakTracer, ProgressRisesToOne) {
  double last = 0;
  StreakRequest request = small_request(0.11, 0);
  trace_streak(request, [&](double share) {
    EXPECT_GT(share, last);
    last = share;
  });
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace pluvia
