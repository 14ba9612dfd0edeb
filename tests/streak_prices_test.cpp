// What approximations of single streaks cost, where closed forms know it.
#include "validate/streak_prices.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "raytrace/sphere_closed_form.h"
#include "tests/streak_samples.h"

namespace pluvia {
namespace {

const std::vector<LightDirection> three_lights = {{10, 150}, {30, 110}, {-30, 50}};

StreakRequest small(const std::vector<Mode>& modes) {
  StreakRequest request = few_rows(1.6e-3, modes, three_lights);
  request.environment = {.uniform = false};
  return request;
}

TEST(StreakPrices, OrdersLeftOutOfASphereAreWhatTheClosedFormHas) {
  // Light of a sphere toward each light with orders 0 .. 1 over that with 0 .. 3, from the closed
  // form in the same cones; the field of 10 cells errs by up to 2 %.
  const StreakRequest streak = small({});
  const auto tags = order_prices({streak}, {1, 3}, 3);
  double cut = 0, all = 0;
  for (const LightDirection& light : three_lights) {
    const double angle = std::acos(light_direction(light.elevation_deg, light.azimuth_deg)
                                       .dot(-view_from_elevation(0).to_camera));
    cut += sphere_intensity_in_cone(1.333, 1, angle, streak.cone_half_angle_rad);
    all += sphere_intensity_in_cone(1.333, 3, angle, streak.cone_half_angle_rad);
  }
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_NEAR(tags[0].price.sum, cut / all, 0.02 * cut / all);
  EXPECT_GT(tags[0].price.light, 0.01);
  EXPECT_EQ(tags[1].price.picture, 0);  // nothing is left out
  EXPECT_EQ(tags[1].price.sum, 1);
}

TEST(StreakPrices, ASphereInsteadOfASphereCostsNothing) {
  EXPECT_EQ(sphere_price({small({})}).price.picture, 0);
  EXPECT_GT(sphere_price({small(published_modes(0.19, 0.1))}).price.picture, 0.1);
}

TEST(StreakPrices, UnpolarisedLightIsTheAverageAtEachInterface) {
  // A ray through a sphere meets both interfaces at one angle: with R_s and R_p there, order 1 has
  // ((1 - R_s)^2 + (1 - R_p)^2) / 2 polarised and (1 - (R_s + R_p) / 2)^2 averaged, which is less
  // by ((R_s - R_p) / 2)^2: never more light. Order 2 gains: it holds R of a ray that order 1 left
  // as s. All orders together return what came in, whatever the polarisation.
  StreakRequest streak = small({});
  streak.lights = {{0, 180}, {0, 130}, {0, 100}, {0, 40}};
  streak.field.paths.max_order = 1;
  const BruteOptions few = {.replicates = 2, .instants = 12, .rays_per_instant = 3000};
  const Price once = polarisation_price({streak}, few).price;
  EXPECT_LT(once.sum, 1);
  EXPECT_GT(once.light, 1e-5);
  streak.environment = {.uniform = true};
  streak.field.paths.max_order = 30;
  BruteOptions averaged = few;
  averaged.polarised = false;
  const BruteStreak with = brute_force_streak(streak, few);
  const BruteStreak without = brute_force_streak(streak, averaged);
  EXPECT_NEAR(without.env_flux.mean, with.env_flux.mean, 1e-4 * with.env_flux.mean);
  EXPECT_NEAR(with.env_flux.mean, with.coverage_flux.mean, 1e-3 * with.env_flux.mean);
  averaged.follower = RayFollower::wide;
  EXPECT_THROW(brute_force_streak(streak, averaged), std::invalid_argument);
}

TEST(StreakPrices, OneIndexForThreeColoursCostsLittleBetweenTheBows) {
  // d ln (light) / dn of a few units over a spread of +- 0.004 in the index: below 10 %, not 0.
  const PriceTag tag = dispersion_price({small({})});
  EXPECT_GT(tag.price.light, 1e-3);
  EXPECT_LT(tag.price.light, 0.1);
  EXPECT_NEAR(tag.price.sum, 1, 0.02);
}

TEST(StreakPrices, TheRuleOf2006CoversASquareForADisc) {
  // A rigid sphere covers pi r0^2, the rule (2 r0)^2: 4 / pi times as much; with the drop's own
  // area there is no error of light.
  StreakRequest streak = forty_rows(1.6e-3, 0, 0);
  streak.environment = {.uniform = false};
  streak.lights = {{10, 150}};
  const auto tags = coverage_prices({streak, streak});
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_NEAR(tags[0].price.sum, 4 / std::numbers::pi, 0.005);
  EXPECT_NEAR(tags[0].price.light, 4 / std::numbers::pi - 1, 0.005);
  EXPECT_NEAR(tags[1].price.sum, 1, 1e-6);
  EXPECT_GT(tags[1].price.picture, 0.1);
}

TEST(StreakPrices, AnEvenSkyNeedsNoHarmonicsAndAPatternDoes) {
  StreakRequest streak = small(published_modes(0.1, 0.1));
  Image even = make_image(16, 8, 3);
  for (float& value : even.values) value = 2;
  const auto flat = sky_prices({streak}, even, 2, 1);
  ASSERT_EQ(flat.size(), 2u);
  // The projection of a map errs by up to 6e-5 of its mean; pictures are floats.
  EXPECT_LT(flat[0].price.picture, 1e-3);
  EXPECT_LT(flat[1].price.picture, 1e-3);
  Image half = even;  // light from one side alone
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (int c = 0; c < 3; ++c) half.at(x, y, c) = 0;
    }
  }
  const auto sided = sky_prices({streak}, half, 2, 3);
  EXPECT_GT(sided[0].price.picture, 0.2);
  EXPECT_LT(sided[3].price.picture, 0.6 * sided[0].price.picture);
}

TEST(StreakPrices, ARequestIsThePresetsFromAnyView) {
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  for (const int view : {0, 20, 40}) {
    const StreakRequest ours = streak_of(preset, 7, view, three_lights);
    const StreakFrame published = gn2006_frame(preset, view);
    EXPECT_NEAR(ours.frame.path_rows, published.path_rows, 1e-9);
    EXPECT_EQ(ours.frame.pixel_m, published.pixel_m);
    // Published heights leave less room below the path.
    EXPECT_NEAR(ours.frame.height_px, published.height_px, 0.04 * published.height_px) << view;
    EXPECT_EQ(ours.lights, three_lights);
  }
}

}  // namespace
}  // namespace pluvia
