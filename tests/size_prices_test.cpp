// Pictures of one drop size for another.
#include "validate/size_prices.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/streak_samples.h"

namespace pluvia {
namespace {

double total(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// One column whose value is 1 + its row.
StreakImage ramp(const StreakFrame& frame) {
  StreakImage image;
  for (int i = 0; i < frame.width_px * frame.height_px; ++i)
    image.mean.push_back(static_cast<float>(1 + i / frame.width_px));
  return image;
}

TEST(SizePrices, ADropOfTheSameSizeIsItsOwnPicture) {
  const StreakRequest known = forty_rows(1.6e-3, 0.1, 0.1);
  const StreakRequest wanted = of_radius(known, 1.6e-3);
  EXPECT_DOUBLE_EQ(pictures_in_exposure(known, wanted), 1);
  const StreakImage picture = ramp(known.frame);
  const auto same = repeated(picture, known, wanted, 1);
  ASSERT_EQ(same.size(), picture.mean.size());
  for (std::size_t i = 0; i < same.size(); ++i) EXPECT_NEAR(same[i], picture.mean[i], 1e-4);
}

TEST(SizePrices, RadiusTimesFourMakesPeriodsEightTimesAsLong) {
  const StreakRequest known = forty_rows(1e-3, 0.1, 0);
  const StreakRequest wanted = of_radius(known, 4e-3);
  EXPECT_DOUBLE_EQ(pictures_in_exposure(known, wanted), 1.0 / 8);
  // Twice as fast in pixels four times as large.
  EXPECT_DOUBLE_EQ(wanted.frame.path_rows, 20);
  EXPECT_EQ(wanted.frame.height_px, 44);
  EXPECT_DOUBLE_EQ(wanted.frame.pixel_m, 4 * known.frame.pixel_m);
}

TEST(SizePrices, RepetitionKeepsAllLightWhereThePathIsWhole) {
  const StreakRequest known = forty_rows(1.6e-3, 0.1, 0);
  StreakImage picture = ramp(known.frame);
  const StreakRequest wanted = of_radius(known, 0.4e-3);
  // 3 whole pictures of a third of the light each.
  EXPECT_NEAR(total(repeated(picture, known, wanted, 3)), total(picture.mean),
              1e-5 * total(picture.mean));
}

TEST(SizePrices, TheShutterCutsThePictureOff) {
  // Of an even picture without ends, 0.6 of it is shown over the whole path: as bright as before.
  const StreakRequest known = forty_rows(1.6e-3, 0.1, 0);
  StreakImage even = ramp(known.frame);
  for (int y = 0; y < known.frame.height_px; ++y) {
    const bool on_path = y >= 12 && y < 52;
    for (int x = 0; x < 16; ++x)
      even.mean[static_cast<std::size_t>(16 * y + x)] = on_path ? 1.0f : 0.0f;
  }
  const auto cut = repeated(even, known, known, 0.6);
  for (int y = 12; y < 52; ++y) EXPECT_NEAR(cut[static_cast<std::size_t>(16 * y)], 1, 1e-5) << y;
  EXPECT_NEAR(cut[16 * 52], 0, 1e-9);
}

TEST(SizePrices, ARigidSphereCostsNothingButItsEnds) {
  // A sphere's streak is even along the path: stretched it is what is traced, but for the rows at
  // the ends, 11 of some 50, where the drop is in the picture for a part of the time.
  StreakRequest known = forty_rows(1.6e-3, 0, 0);
  known.lights = {{10, 150}, {30, 110}, {-30, 90}};
  known.environment = {.uniform = false};
  const auto tags = size_prices({known}, {1.2e-3});
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_LT(tags[0].price.light, 0.01);
  EXPECT_LT(tags[0].price.picture, 0.1);
}

TEST(SizePrices, OneModeIsRepeatedRightAndStretchedWrong) {
  // Mode (2, 0) alone closes after its period (59.97 Hz at 1.6 mm: one in 1/60 s): the repeated
  // picture is the traced one where the streak is long beside the drop, the stretched one is not.
  StreakRequest known = forty_rows(1.6e-3, 0.19, 0);
  known.frame.path_rows = 200;
  known.frame.height_px = 224;
  known.slices = 200;
  known.lights = {{10, 150}, {30, 110}, {-30, 90}};
  known.environment = {.uniform = false};
  const auto tags = size_prices({known}, {1.0e-3});
  EXPECT_LT(tags[1].price.picture, 0.5 * tags[0].price.picture);
}

}  // namespace
}  // namespace pluvia
