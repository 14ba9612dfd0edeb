// What grids of directions cost, for pictures whose dependence on the direction is known.
#include "validate/grid_prices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/streak_samples.h"

namespace pluvia {
namespace {

// Of a picture of 2 x 1 pixels: (f, 2 f) of the directions.
template <typename F>
PictureGrid grid_of(int step_deg, const std::vector<int>& views, F f) {
  PictureGrid grid = {.width_px = 2, .lights = light_grid(step_deg)};
  for (const int view : views) {
    LitView& lit = grid.views.emplace_back();
    lit.elevation_deg = view;
    for (const LightDirection& light : grid.lights) {
      const auto value = static_cast<float>(f(view, light.elevation_deg, light.azimuth_deg));
      lit.pictures.push_back({.mean = {value, 2 * value}});
    }
  }
  return grid;
}

TEST(GridPrices, EachGridHoldsTheCoarserOnes) {
  EXPECT_EQ(light_grid(20).size(), 74u);
  EXPECT_EQ(light_grid(10).size(), 17u * 19 + 2);
  EXPECT_EQ(light_grid(5).size(), 35u * 37 + 2);
  for (const int step : {20, 10}) {
    const auto finer = light_grid(step / 2);
    for (const LightDirection& light : light_grid(step))
      EXPECT_NE(std::find(finer.begin(), finer.end(), light), finer.end()) << light_name(light);
  }
  EXPECT_THROW(light_grid(7), std::invalid_argument);
}

TEST(GridPrices, DirectionsInBetweenAreEvenOverTheSphereAndOnNoGrid) {
  const auto lights = lights_between(200);
  const auto grid = light_grid(5);
  double height = 0, square = 0, forward = 0;
  for (const LightDirection& light : lights) {
    EXPECT_EQ(std::find(grid.begin(), grid.end(), light), grid.end());
    EXPECT_GE(light.azimuth_deg, 0);
    EXPECT_LE(light.azimuth_deg, 180);
    const double z = std::sin(light.elevation_deg * std::numbers::pi / 180);
    const double x = std::sqrt(1 - z * z) * std::cos(light.azimuth_deg * std::numbers::pi / 180);
    height += z / 200;
    square += z * z / 200;
    forward += x / 200;
  }
  // Moments of the sphere: 0, 1/3, 0; whole degrees and 200 points leave 0.01.
  EXPECT_NEAR(height, 0, 0.01);
  EXPECT_NEAR(square, 1.0 / 3, 0.01);
  EXPECT_NEAR(forward, 0, 0.01);
}

TEST(GridPrices, AConstantPictureHasNoAngularError) {
  const PictureGrid grid = grid_of(20, {0, 20}, [](double, double, double) { return 3; });
  for (const LightDirection& light : lights_between(50)) {
    for (const LookupMode mode :
         {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear}) {
      const auto picture = looked_up(grid, 7, light.elevation_deg, light.azimuth_deg, mode);
      // Where the light is beyond the grid's azimuths, columns are flipped: sums do not change.
      EXPECT_NEAR(picture[0] + picture[1], 9, 1e-5) << light_name(light);
    }
  }
}

TEST(GridPrices, ALinearFunctionOfTheAnglesHasNoErrorUnderTrilinear) {
  const auto f = [](double view, double v, double h) { return 100 + view + 0.3 * v + 0.2 * h; };
  for (const int step : {20, 10, 5}) {
    const PictureGrid grid = grid_of(step, {0, 20}, f);
    for (const auto& [view, v, h] :
         {std::array{7, 13, 57}, {0, -33, 170}, {20, 4, 11}, {11, 69, 99}}) {
      const auto picture = looked_up(grid, view, v, h, LookupMode::trilinear);
      EXPECT_NEAR(picture[0], f(view, v, h), 1e-4) << step << ": " << view << " " << v << " " << h;
      EXPECT_NEAR(picture[1], 2 * f(view, v, h), 2e-4);
    }
    // The nearest light is up to half a step off.
    const auto nearest = looked_up(grid, 7, 13, 57, LookupMode::view_linear);
    EXPECT_GT(std::abs(static_cast<double>(nearest[0]) - f(7, 13, 57)), 0.1) << step;
    EXPECT_LT(std::abs(static_cast<double>(nearest[0]) - f(7, 13, 57)), 0.5 * 0.5 * step) << step;
  }
}

TEST(GridPrices, LightFromTheOtherSideIsTheMirroredPicture) {
  const PictureGrid grid = grid_of(10, {0}, [](double, double v, double h) { return 200 + v + h; });
  const auto right = looked_up(grid, 0, 10, 50, LookupMode::nearest);
  const auto left = looked_up(grid, 0, 10, -50, LookupMode::nearest);
  EXPECT_EQ(right, (std::vector<float>{260, 520}));
  EXPECT_EQ(left, (std::vector<float>{520, 260}));
}

TEST(GridPrices, APartOfAGridHasItsPictures) {
  const PictureGrid fine =
      grid_of(5, {0}, [](double, double v, double h) { return 500 + v + 7 * h; });
  const PictureGrid coarse = part_of(fine, light_grid(20));
  ASSERT_EQ(coarse.views[0].pictures.size(), 74u);
  for (std::size_t i = 0; i < 74; ++i)
    EXPECT_EQ(coarse.views[0].pictures[i].mean[0],
              static_cast<float>(500 + coarse.lights[i].elevation_deg +
                                 7 * coarse.lights[i].azimuth_deg));
  EXPECT_THROW(part_of(coarse, {{1, 2}}), std::invalid_argument);
}

TEST(GridPrices, ASphereUnderAFinerGridIsNearerToItsOwnLight) {
  // A rigid sphere from two views: as its light depends on the angle to the light alone, and falls
  // off smoothly but for the bows, halving the step must bring trilinear lights nearer.
  StreakRequest request = few_rows(1.6e-3, {}, {});
  const auto tags = light_grid_prices({request}, 10, lights_between(40));
  ASSERT_EQ(tags.size(), 4u);  // steps 20, 10, each nearest and trilinear
  EXPECT_LT(tags[2].price.light, tags[0].price.light);
  EXPECT_LT(tags[3].price.light, tags[1].price.light);
  EXPECT_GT(tags[3].price.light, 0);
  // Views: a sphere looks the same from everywhere, but the light is where it is.
  request.lights = {{10, 150}, {30, 110}, {-30, 90}, {50, 70}};
  const auto views = view_grid_prices({request}, 10, {7, 13}, 20);
  ASSERT_EQ(views.size(), 4u);
  EXPECT_LT(views[3].price.light, views[0].price.light);
}

TEST(GridPrices, BytesGoWithTheNumberOfCells) {
  const double coarse = atlas_bytes(10, 20, 20, 1000);
  EXPECT_DOUBLE_EQ(atlas_bytes(10, 10, 20, 1000) / coarse, 325.0 / 74);
  EXPECT_NEAR(coarse, 4.0 * 10 * 74 * 1000 * 3.38, 0.01 * coarse);  // cosines of 0, 20 .. 80
}

}  // namespace
}  // namespace pluvia
