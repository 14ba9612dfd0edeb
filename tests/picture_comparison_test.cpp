#include "validate/picture_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "validate/checks.h"

namespace pluvia {
namespace {

// A wall that brightens to the right, behind upright streaks of one or two pixels.
struct Shower {
  int width = 192, height = 180;
  double wall = 0.2, streak = 0.5;
  int columns_off = 0;  // by which every streak is moved
};

Image wall_of(const Shower& shower) {
  Image image = make_image(shower.width, shower.height, 3);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const double x = static_cast<double>(i / 3 % static_cast<std::size_t>(shower.width));
    image.values[i] = static_cast<float>(shower.wall * (1 + x / shower.width));
  }
  return image;
}

Image rain_on(const Shower& shower) {
  Image image = wall_of(shower);
  std::mt19937 random(4);
  for (int streak = 0; streak < 60; ++streak) {
    const int x = 20 + static_cast<int>(random() % 150), y = static_cast<int>(random() % 135);
    for (int row = y; row < y + 40; ++row) {
      for (int c = 0; c < 3; ++c) {
        const double light = shower.streak * (1 + 0.2 * (streak % 5)) * (1 + 0.1 * c);
        image.at(x + shower.columns_off, row, c) += static_cast<float>(light);
        image.at(x + shower.columns_off + 1, row, c) += static_cast<float>(light / 2);
      }
    }
  }
  return image;
}

ComparedPictures compared(const Shower& shower, double brighter = 1) {
  Shower other = shower;
  other.streak *= brighter;
  Shower in_place = shower;
  in_place.columns_off = 0;
  const StreakMask all = {
      .width = shower.width,
      .height = shower.height,
      .touched = std::vector<bool>(static_cast<std::size_t>(shower.width * shower.height), true)};
  return {.picture = rain_on(other),
          .reference = rain_on(in_place),
          .dry = wall_of(shower),
          .white = 2,
          .streaks = {all}};
}

TEST(PictureComparison, OfEqualPicturesIsZeroInEveryMetric) {
  const PictureComparison same = compare_pictures(compared({}));
  EXPECT_EQ(same.rain.relative_rmse, 0);
  EXPECT_TRUE(same.rain.below_noise);
  EXPECT_FALSE(same.ldr.psnr_db || same.hdr.psnr_db);
  EXPECT_EQ(same.ssim.error.largest, 0);
  EXPECT_NEAR(*same.ssim.ms_ssim, 1, 1e-12);
  EXPECT_EQ(same.ldr_flip.largest, 0);
  ASSERT_TRUE(same.hdr_flip.has_value());
  EXPECT_EQ(same.hdr_flip->error.largest, 0);
  EXPECT_EQ(same.flux->of_typical.largest, 0);
  EXPECT_EQ(*same.statistics.brightness.value, 0);
  EXPECT_EQ(*same.statistics.width_px.value, 0);
  EXPECT_EQ(*same.statistics.lean_deg.value, 0);
  EXPECT_EQ(same.statistics.spectrum.rings_db, 0);
}

TEST(PictureComparison, OfRainATenthTooBrightIsATenth) {
  const PictureComparison found = compare_pictures(compared({}, 1.1));
  // The layers are differences of floats about 1: 1e-7 / 0.1.
  EXPECT_NEAR(found.rain.relative_rmse, 0.1, 1e-5);
  EXPECT_NEAR(found.flux->all.relative_rmse, 0.1, 1e-5);
  EXPECT_NEAR(*found.statistics.brightness.value, 0.1, 1e-4);
  EXPECT_NEAR(*found.statistics.lean_deg.value, 0, 1e-2);
  EXPECT_NEAR(found.statistics.spectrum.rings_db, 20 * std::log10(1.1), 1e-2);
  EXPECT_GT(found.ldr_flip.mean, 0.001);
  EXPECT_GT(found.hdr_flip->error.mean, 0.001);
  EXPECT_GT(found.ssim.error.mean, 1e-5);
}

TEST(PictureComparison, OfStreaksInOtherPlacesIsLargeInPixelsAndSmallInStatistics) {
  const PictureComparison found = compare_pictures(compared({.columns_off = 3}));
  EXPECT_GT(found.rain.relative_rmse, 0.5);
  EXPECT_LT(*found.statistics.brightness.value, 0.01);
  EXPECT_LT(*found.statistics.width_px.value, 0.01);
  EXPECT_LT(*found.statistics.lean_deg.value, 0.1);
  EXPECT_LT(found.flux->all.relative_rmse, 1e-5);  // one mask over all
}

TEST(PictureComparison, TellsADifferenceBelowTheNoiseOfTheReference) {
  ComparedPictures pictures = compared({}, 1.002);
  pictures.variance = make_image(192, 180, 3);
  for (float& v : pictures.variance->values) v = 1e-4f;
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0, 0.01);
  for (float& v : pictures.reference.values) v += static_cast<float>(noise(random));
  EXPECT_TRUE(compare_pictures(pictures).rain.below_noise);
  pictures.variance.reset();
  EXPECT_FALSE(compare_pictures(pictures).rain.below_noise);
}

TEST(PictureComparison, OfRainBeforeNothingHasNoAutomaticExposures) {
  const PictureComparison found = compare_pictures(compared({.wall = 0}, 1.1));
  EXPECT_FALSE(found.hdr_flip.has_value());
  EXPECT_EQ(found.no_hdr_flip,
            "hdr_flip: the reference's median luminance is 0; expected > 0, or given exposures");
}

TEST(PictureComparison, RoundingToBytesIsWhatAScreenShows) {
  // 0.25 of white is 0.537099 in sRGB, 136.96 of 255: 137 is 0.250158.
  const Image rounded = rounded_to_bytes({4, 1, 1, {0, 0.5f, 2, 7}}, 2);
  EXPECT_EQ(rounded.values[0], 0);
  EXPECT_NEAR(rounded.values[1], 2 * 0.250158, 1e-6);
  EXPECT_NEAR(rounded.values[2], 2, 1e-6);
  EXPECT_NEAR(rounded.values[3], 2, 1e-6);
}

TEST(PictureComparison, RefusesPicturesThatDoNotBelongTogether) {
  ComparedPictures pictures = compared({});
  pictures.dry = make_image(192, 181, 3);
  EXPECT_THROW(compare_pictures(pictures), std::runtime_error);
  pictures = compared({});
  pictures.picture.at(3, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(compare_pictures(pictures), std::runtime_error);
}

std::vector<std::string> failures(const ComparedPictures& pictures, Report& report) {
  add_picture_checks("frame", pictures, report);
  std::vector<std::string> names;
  for (const Check& check : report.checks) {
    if (!passes(check)) names.push_back(check.name);
  }
  return names;
}

TEST(PictureChecks, OfEqualPicturesPassWithATableAndMaps) {
  Report report;
  EXPECT_TRUE(failures(compared({}), report).empty());
  EXPECT_EQ(report.checks.size(), 12u);
  EXPECT_TRUE(report.skipped.empty());
  EXPECT_EQ(report.tables.at(0).rows.size(), 5u);
  EXPECT_EQ(report.comparisons.at(0).maps.size(), 4u);
}

TEST(PictureChecks, FailWhereTheRainIsATenthTooBright) {
  Report report;
  const std::vector<std::string> names = failures(compared({}, 1.1), report);
  for (const char* name :
       {"frame.psnr.ldr", "frame.ssim", "frame.psnr.hdr", "frame.flip.hdr", "frame.streak_flux",
        "frame.streaks.brightness", "frame.spectrum.rings", "frame.spectrum.sectors"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  EXPECT_EQ(std::find(names.begin(), names.end(), "frame.streaks.lean"), names.end());
}

TEST(PictureChecks, FailWhereTheRainIsMissing) {
  Report report;
  ComparedPictures pictures = compared({});
  pictures.picture = pictures.dry;
  EXPECT_EQ(failures(pictures, report).size(), 12u);
}

TEST(PictureChecks, SayWhatASmallPictureBeforeNothingLeavesOut) {
  Report report;
  ComparedPictures pictures = compared({.height = 175, .wall = 0});
  pictures.streaks.clear();
  EXPECT_TRUE(failures(pictures, report).empty());
  EXPECT_EQ(report.checks.size(), 9u);
  EXPECT_EQ(report.skipped.size(), 3u);
}

}  // namespace
}  // namespace pluvia
