// Strokes cut out of mattes that are known.
#include "validate/rain_strokes.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/rain_clip.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

// One streak of peak 0.5, Gaussian across with 1.2 px, 40 px long with soft ends, middle (x, y).
Image streak(double x_px, double y_px, double lean_deg) {
  Image matte = make_image(120, 100);
  const double lean = lean_deg * std::numbers::pi / 180;
  for (int y = 0; y < matte.height; ++y) {
    for (int x = 0; x < matte.width; ++x) {
      const double dx = x + 0.5 - x_px, dy = y + 0.5 - y_px;
      const double along = dx * std::sin(lean) + dy * std::cos(lean);
      const double across = dx * std::cos(lean) - dy * std::sin(lean);
      const double end = std::clamp(20.5 - std::abs(along), 0.0, 1.0);
      matte.at(x, y) = static_cast<float>(0.5 * end * std::exp(-across * across / 2.88));
    }
  }
  return matte;
}

Image both(const Image& a, const Image& b) {
  Image sum = a;
  for (std::size_t i = 0; i < sum.values.size(); ++i)
    sum.values[i] = std::max(sum.values[i], b.values[i]);
  return sum;
}

TEST(RainStrokes, HaveTheSizePlaceAndCoverOfTheStreaks) {
  for (const double lean_deg : {0.0, 14.0, -14.0, 40.0, -60.0}) {
    const auto strokes =
        rain_strokes({streak(30, 40, lean_deg), streak(80, 55, lean_deg)}, lean_deg, {});
    ASSERT_EQ(strokes.size(), 2u) << lean_deg;
    for (int k = 0; k < 2; ++k) {
      const RainStroke& stroke = strokes[static_cast<std::size_t>(k)];
      EXPECT_EQ(stroke.frame, k);
      EXPECT_NEAR(stroke.x_px, k == 0 ? 30 : 80, 0.3) << lean_deg;
      EXPECT_NEAR(stroke.y_px, k == 0 ? 40 : 55, 0.3) << lean_deg;
      // Half of its largest value is 20 px from the middle; a row to either side.
      EXPECT_NEAR(stroke.length_px, 40, 2) << lean_deg;
      // A peak between two pixels shows exp(-0.5^2 / 2.88) = 0.917 of itself; a triangle of 1 px
      // has a variance of 1/6, which lowers it to 1.2 / 1.268; the soft ends take up to 5 per cent.
      const double least = 0.917 * 1.2 / std::sqrt(1.44 + 1.0 / 6);
      EXPECT_GT(stroke.width_px, 2.507 * 1.2 * 0.99) << lean_deg;
      EXPECT_LT(stroke.width_px, 2.507 * 1.2 / least) << lean_deg;
      EXPECT_GT(stroke.brightness, 0.5 * least * 0.95) << lean_deg;
      EXPECT_LT(stroke.brightness, 0.5) << lean_deg;
      EXPECT_GT(stroke.matte.height, 2 * stroke.matte.width) << "upright";
    }
  }
}

TEST(RainStrokes, ThatCrossTouchOrAreCutByTheBorderAreLeftOut) {
  const auto count = [](const Image& matte, double lean_deg) {
    return rain_strokes({matte}, lean_deg, {}).size();
  };
  EXPECT_EQ(count(both(streak(40, 50, 0), streak(80, 50, 0)), 0), 2u);
  EXPECT_EQ(count(both(streak(60, 50, 0), streak(63, 60, 0)), 0), 0u);
  EXPECT_EQ(count(both(streak(60, 50, 0), streak(60, 50, 25)), 0), 0u);
  EXPECT_EQ(count(streak(60, 15, 0), 0), 0u);
  EXPECT_EQ(count(streak(112, 50, 20), 20), 0u);
}

TEST(RainStrokes, ShorterThanTheOpeningOrFainterThanTheThresholdAreNone) {
  Image specks = make_image(120, 100);
  std::mt19937 random(4);
  for (int i = 0; i < 120; ++i) specks.values[random() % specks.values.size()] = 1;
  EXPECT_EQ(rain_strokes({specks, make_image(120, 100)}, 10, {}).size(), 0u);
  // A tenth as strong as the other.
  Image faint = streak(30, 40, 0);
  for (float& value : faint.values) value *= 0.1f;
  const Image both_strengths = both(faint, streak(80, 50, 0));
  EXPECT_EQ(rain_strokes({both_strengths}, 0, {}).size(), 1u);
  EXPECT_EQ(rain_strokes({both_strengths}, 0, {.least_share = 0.05}).size(), 2u);
  // All of them faint, as where the rain's colour was taken too bright.
  EXPECT_EQ(rain_strokes({faint}, 0, {}).size(), 1u);
  EXPECT_EQ(rain_strokes({make_image(120, 100)}, 0, {}).size(), 0u);
}

TEST(RainStrokes, RefuseSettingsOutOfRange) {
  for (const StrokeSettings& settings :
       {StrokeSettings{.opening_px = 4}, StrokeSettings{.blur_px = -1},
        StrokeSettings{.least_share = 0}, StrokeSettings{.blur_px = std::nan("")}}) {
    const std::string message =
        message_of([&] { rain_strokes({make_image(20, 20)}, 0, settings); });
    EXPECT_NE(message.find("expected an odd number >= 1"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace pluvia
