#include "validate/streak_flux.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

// A slanted streak of 4 x 20 texels of value 3, each 1.5 x 2 pixels.
struct Laid {
  StreakPlacement placement = {};
  StreakPicture picture = {};
  Footprint footprint = {};
};

Laid laid_streak(double x, double y) {
  Laid laid;
  laid.placement.origin_px = {x, y};
  laid.placement.column_px = {1.5, 0.1};
  laid.placement.row_px = {-0.4, 2};
  laid.placement.path_rows = 15;
  laid.placement.clip_row = 1e9;
  laid.picture = {.width = 4, .height = 20, .path_top_row = 2, .path_rows = 15};
  laid.picture.values.assign(80, {3, 3, 3, 0.5});
  laid.footprint = empty_footprint(laid.placement, {laid.picture}, 64, 64);
  add_streak(laid.placement, laid.picture, laid.footprint);
  return laid;
}

void add_to(Image& image, const Footprint& footprint, double factor) {
  for (int y = 0; y < footprint.height; ++y) {
    for (int x = 0; x < footprint.width; ++x) {
      const auto& value = footprint.values[static_cast<std::size_t>(y * footprint.width + x)];
      for (int c = 0; c < 3; ++c) {
        image.at(footprint.x0 + x, footprint.y0 + y, c) += static_cast<float>(factor * value[c]);
      }
    }
  }
}

TEST(StreakFlux, IsValueTimesArea) {
  const Laid one = laid_streak(20, 5), two = laid_streak(40, 10);
  Image truth = make_image(64, 64, 3), rain = truth;
  add_to(truth, one.footprint, 1), add_to(truth, two.footprint, 1);
  add_to(rain, one.footprint, 1.25), add_to(rain, two.footprint, 0.75);
  const auto fluxes = streak_fluxes(rain, truth, {mask_of(one.footprint), mask_of(two.footprint)});
  // |column x row| = 1.5 2 + 0.4 0.1 = 3.04 px^2 a texel, 80 of them; pixels are floats.
  const double flux = 3 * 80 * 3.04;
  EXPECT_NEAR(fluxes[0].truth, flux, 1e-4 * flux);
  EXPECT_NEAR(fluxes[1].truth, flux, 1e-4 * flux);
  EXPECT_NEAR(fluxes[0].measured, 1.25 * flux, 1e-4 * flux);
  EXPECT_NEAR(fluxes[1].measured, 0.75 * flux, 1e-4 * flux);
  const FluxError error = flux_error(fluxes);
  EXPECT_NEAR(error.all.relative_rmse, 0.25, 1e-5);
  EXPECT_NEAR(error.of_typical.largest, 0.25, 1e-5);
  EXPECT_FALSE(error.all.below_noise);
}

TEST(StreakFlux, OfLightThatMovesWithinAStreakIsRight) {
  const Laid laid = laid_streak(20, 5);
  Image truth = make_image(64, 64, 3), rain = truth;
  add_to(truth, laid.footprint, 1);
  rain = truth;
  for (int c = 0; c < 3; ++c) std::swap(rain.at(20, 20, c), rain.at(16, 30, c));
  rain.at(20, 20, 1) += 1, rain.at(16, 30, 1) -= 1;
  EXPECT_GT(relative_rmse(rain, truth), 0.01);
  const FluxError error = flux_error(streak_fluxes(rain, truth, {mask_of(laid.footprint)}));
  EXPECT_NEAR(error.all.relative_rmse, 0, 1e-6);
}

TEST(StreakFlux, CarriesTheNoiseOfTheTruth) {
  const StreakMask mask = {
      .x0 = 3, .y0 = 4, .width = 5, .height = 2, .touched = std::vector<bool>(10, true)};
  Image truth = make_image(20, 20, 3), variance = truth;
  for (float& v : variance.values) v = 0.04f;
  // Ten pixels of variance 0.04 (0.2126^2 + 0.7152^2 + 0.0722^2) = 0.04 0.56193.
  EXPECT_NEAR(streak_fluxes(truth, truth, {mask}, variance)[0].standard_error,
              std::sqrt(0.4 * 0.56193), 1e-5);
  // A truth that scatters so, a picture without error: below the noise.
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<StreakFlux> fluxes;
  for (int i = 0; i < 300; ++i) fluxes.push_back({1, 1 + noise(random), 0.1});
  EXPECT_TRUE(flux_error(fluxes).all.below_noise);
  for (StreakFlux& flux : fluxes) flux.measured = 1.1;
  EXPECT_FALSE(flux_error(fluxes).all.below_noise);
  EXPECT_NEAR(std::sqrt(flux_error(fluxes).all.squared), 0.1, 0.02);
}

TEST(StreakFlux, RefusesMasksThatLeaveThePictureAndNoStreakAtAll) {
  const Image picture = make_image(20, 20);
  StreakMask mask = {
      .x0 = 16, .y0 = 4, .width = 5, .height = 1, .touched = std::vector<bool>(5, true)};
  EXPECT_THROW(streak_fluxes(picture, picture, {mask}), std::runtime_error);
  mask.x0 = 15;
  EXPECT_NO_THROW(streak_fluxes(picture, picture, {mask}));
  mask.touched.pop_back();
  EXPECT_THROW(streak_fluxes(picture, picture, {mask}), std::runtime_error);
  EXPECT_THROW(flux_error({}), std::runtime_error);
  EXPECT_THROW(flux_error({{1, 0, 0}}), std::runtime_error);
  EXPECT_EQ(flux_error({{0, 0, 0}}).all.relative_rmse, 0);
}

}  // namespace
}  // namespace pluvia
