#include "atlas/stroke_coverage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "tests/made_up_strokes.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

std::string refusal_of(const std::string& folder) {
  return message_of([&] { read_streak_strokes(folder); });
}

std::string folder_with(const TemporaryFolder& folder, const Image& stroke) {
  std::filesystem::create_directories(folder / "strokes");
  write_exr(folder / "strokes/0000.exr", stroke);
  return folder / "";
}

TEST(StreakStrokes, AFolderOfMattesIsReadInTheOrderOfItsNames) {
  const TemporaryFolder folder;
  const std::string path = folder_with(folder, beaded_stroke().matte);
  write_exr(folder / "strokes/0001.exr", one_pixel().matte);
  write_png(folder / "strokes/0000.png", beaded_stroke().matte);  // beside, as `mattes` writes it
  const StreakStrokes strokes = read_streak_strokes(path);
  ASSERT_EQ(strokes.taken.size(), 2u);
  EXPECT_EQ(strokes.found, 2u);
  EXPECT_EQ(strokes.taken[0].matte.values, beaded_stroke().matte.values);
  EXPECT_EQ(strokes.taken[1].matte.values, one_pixel().matte.values);
}

TEST(StreakStrokes, OfTooManyTheLongestAreTaken) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "strokes");
  for (int i = 0; i < 70; ++i)  // 6 of them are short
    write_exr(folder / ("strokes/" + std::to_string(1000 + i) + ".exr"),
              beaded_stroke(i % 12 == 5 ? 8 : 9).matte);
  const StreakStrokes strokes = read_streak_strokes(folder / "");
  EXPECT_EQ(strokes.found, 70u);
  ASSERT_EQ(strokes.taken.size(), most_strokes);
  std::set<std::string> names;
  for (const StreakStroke& stroke : strokes.taken) {
    EXPECT_EQ(stroke.matte.height, 9);
    EXPECT_TRUE(names.empty() || stroke.file > *names.rbegin());
    names.insert(stroke.file);
  }
}

TEST(StreakStrokes, AFolderWithoutStrokesIsRefused) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal_of(folder / "nowhere"), HasSubstr("nowhere/strokes: cannot read"));
  EXPECT_THAT(refusal_of(folder / ""), HasSubstr("strokes: cannot read"));
  std::filesystem::create_directories(folder / "strokes");
  EXPECT_THAT(refusal_of(folder / ""), HasSubstr("strokes/*.exr: no file of that name"));
}

TEST(StreakStrokes, APictureThatIsNoStrokeIsRefusedByName) {
  const auto refusal = [](const Image& picture) {
    const TemporaryFolder folder;
    return refusal_of(folder_with(folder, picture));
  };
  Image negative = beaded_stroke().matte;
  negative.at(2, 3) = -0.5f;
  EXPECT_THAT(refusal(make_image(5, 20)), HasSubstr("0000.exr: is black; expected a stroke"));
  EXPECT_THAT(refusal(negative), HasSubstr("0000.exr: has a value -0.5; expected >= 0"));
  EXPECT_THAT(refusal(make_image(5, 20, 3)), HasSubstr("0000.exr: 3 channels; expected 1"));
  EXPECT_THAT(refusal(make_image(1, 4097)), HasSubstr("1 x 4097 pixels; expected at most"));
}

TEST(StreakStrokes, AFileThatIsNoPictureIsRefusedByName) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "strokes");
  std::ofstream(folder / "strokes/0000.exr") << "no picture";
  EXPECT_THAT(refusal_of(folder / ""), HasSubstr("strokes/0000.exr: "));
}

TEST(StreakStrokes, ThoseThatAreShippedCanBeDrawn) {
  StreakAtlas atlas = quarter_atlas();
  atlas.strokes = read_streak_strokes(PLUVIA_SOURCE_DIR "/data/mattes");
  EXPECT_EQ(atlas.strokes.taken.size(), 12u);
  EXPECT_EQ(stroke_coverage(atlas, 1).layers.size(), 20u);
}

StreakAtlas atlas_with(StreakStroke stroke) {
  StreakAtlas atlas = quarter_atlas();
  atlas.strokes = strokes_of({std::move(stroke)});
  return atlas;
}

double sum_of(const Image& picture, const CellRect& cell) {
  double sum = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x)
      sum += static_cast<double>(picture.at(cell.x + x, cell.y + y));
  }
  return sum;
}

// Of the cell's rows in a picture, each over the sum of all.
std::vector<double> row_shares(const Image& picture, const CellRect& cell) {
  std::vector<double> rows;
  for (int y = 0; y < cell.height; ++y)
    rows.push_back(sum_of(picture, {cell.x, cell.y + y, cell.width, 1}) / sum_of(picture, cell));
  return rows;
}

TEST(StrokeCoverage, EveryViewCoversAsMuchAsTheDrop) {
  for (const StreakStroke& stroke :
       {beaded_stroke(), beaded_stroke(400, 0.02), one_pixel(), flashing_stroke()}) {
    for (const double most : {1.0, 0.03}) {
      const StreakAtlas atlas = atlas_with(stroke);
      const StreakAtlas shaped = stroke_coverage(atlas, most);
      ASSERT_EQ(shaped.layers.size(), atlas.layers.size());
      for (std::size_t i = 0; i < atlas.layers.size(); ++i) {
        const Image &plain = atlas.layers[i].coverage[0], &found = shaped.layers[i].coverage[0];
        for (int view = 0; view < 5; ++view) {
          const CellRect cell = cell_rect(atlas, view, 0, 0);
          // Values are rounded to floats, 6e-8 of each.
          EXPECT_NEAR(sum_of(found, cell) / sum_of(plain, cell), 1, 1e-7)
              << stroke.file << " " << i << " " << view;
        }
        // Nothing outside the cells.
        EXPECT_NEAR(sum_of(found, {0, 0, found.width, found.height}) /
                        sum_of(plain, {0, 0, plain.width, plain.height}),
                    1, 1e-7);
      }
    }
  }
}

// The mean over low .. high of values at 0.5, 1.5, .., linear between and 0 around: by 1000 points.
double linear_mean(const std::vector<double>& values, double low, double high) {
  const int points = 1000, count = static_cast<int>(values.size());
  double sum = 0;
  for (int k = 0; k < points; ++k) {
    const double place = low + (high - low) * (k + 0.5) / points - 0.5;
    const int i = static_cast<int>(std::floor(place));
    const double share = place - i;
    if (i >= 0 && i < count) sum += (1 - share) * values[static_cast<std::size_t>(i)];
    if (i >= -1 && i < count - 1) sum += share * values[static_cast<std::size_t>(i + 1)];
  }
  return sum / points;
}

TEST(StrokeCoverage, LightGoesDownAStreakAsDownTheStroke) {
  const StreakStroke stroke = beaded_stroke();
  const StreakAtlas atlas = atlas_with(stroke);
  const Image found = stroke_coverage(atlas, 1).layers[0].coverage[0];
  std::vector<double> beads;
  for (int y = 0; y < 24; ++y) beads.push_back(sum_of(stroke.matte, {0, y, stroke.matte.width, 1}));
  for (int view = 0; view < 5; ++view) {
    // The drop's cells are not 0 but at their rim, whose row is lit, too.
    const CellRect cell = cell_rect(atlas, view, 0, 0);
    std::vector<double> expected;
    double sum = 0;
    for (int y = 0; y < cell.height; ++y) {
      expected.push_back(linear_mean(beads, 24.0 * y / cell.height, 24.0 * (y + 1) / cell.height));
      sum += expected.back();
    }
    const std::vector<double> shares = row_shares(found, cell);
    for (int y = 0; y < cell.height; ++y) {
      const auto i = static_cast<std::size_t>(y);
      // 1000 points err by 1e-6 of the steps that a texel spans; across, each row loses the same.
      EXPECT_NEAR(shares[i], expected[i] / sum, 1e-5 * expected[i] / sum) << view << " " << y;
    }
  }
}

TEST(StrokeCoverage, LightGoesAcrossAStreakAsAcrossTheStroke) {
  const StreakStroke stroke = beaded_stroke();
  const StreakAtlas atlas = atlas_with(stroke);
  const CellRect cell = cell_rect(atlas, 0, 0, 0);
  const Image &plain = atlas.layers[0].coverage[0],
              found = stroke_coverage(atlas, 1).layers[0].coverage[0];
  const auto width_of = [&](const Image& picture, const CellRect& rows) {
    double largest = 0;
    for (int y = 0; y < rows.height; ++y) {
      float row = 0;
      for (int x = 0; x < rows.width; ++x) row = std::max(row, picture.at(rows.x + x, rows.y + y));
      largest += static_cast<double>(row);
    }
    return sum_of(picture, rows) / largest;
  };
  double u_sum = 0;
  for (int x = 0; x < cell.width; ++x)
    u_sum += (x + 0.5) * sum_of(plain, {cell.x + x, cell.y, 1, cell.height});
  const double middle = u_sum / sum_of(plain, cell);
  const double scale =
      width_of(stroke.matte, {0, 0, stroke.matte.width, 24}) / width_of(plain, cell);
  std::vector<double> profile, expected;
  for (int x = 0; x < stroke.matte.width; ++x)
    profile.push_back(static_cast<double>(stroke.matte.at(x, 5)));
  double sum = 0;
  for (int x = 0; x < cell.width; ++x) {
    const double low = 4.5 + scale * (x - middle);
    expected.push_back(linear_mean(profile, low, low + scale));
    sum += expected.back();
  }
  for (int x = 0; x < cell.width; ++x) {
    const double share = sum_of(found, {cell.x + x, cell.y, 1, cell.height}) / sum_of(found, cell);
    EXPECT_NEAR(share, expected[static_cast<std::size_t>(x)] / sum, 1e-5) << x;
  }
}

TEST(StrokeCoverage, AStrokeThatLeansIsSetUpright) {
  const StreakAtlas atlas = quarter_atlas();
  const CellRect cell = cell_rect(atlas, 0, 0, 0);
  // Four pixels to the side, three times the width at half of the largest.
  const Image leaning =
      stroke_coverage(atlas_with(beaded_stroke(200, 0.02)), 1).layers[0].coverage[0];
  const Image straight = stroke_coverage(atlas_with(beaded_stroke(200)), 1).layers[0].coverage[0];
  double off = 0;
  for (int y = 0; y < cell.height; ++y) {
    for (int x = 0; x < cell.width; ++x)
      off += static_cast<double>(
          std::abs(leaning.at(cell.x + x, cell.y + y) - straight.at(cell.x + x, cell.y + y)));
  }
  // A Gaussian of 1.2 px taken between pixels is off by at most f''/8 = 0.09 of its largest value
  // there, 0 elsewhere: half of that in the mean.
  EXPECT_LT(off / sum_of(straight, cell), 0.05);
}

TEST(StrokeCoverage, NoTexelCoversMoreThanItMay) {
  const StreakAtlas atlas = atlas_with(flashing_stroke());
  const Image free = stroke_coverage(atlas, 1).layers[0].coverage[0];
  const float largest = *std::max_element(free.values.begin(), free.values.end());
  for (const float most : {largest, 0.5f * largest, 0.02f}) {
    const Image found = stroke_coverage(atlas, static_cast<double>(most)).layers[0].coverage[0];
    const Image& plain = atlas.layers[0].coverage[0];
    float over = 0;
    for (std::size_t i = 0; i < found.values.size(); ++i)
      over = std::max(over, found.values[i] - std::max(most, plain.values[i]));
    EXPECT_LE(over, 1e-7f) << most;
    // And no more is taken back than needed: some texel is at the bound.
    const bool bound = std::any_of(found.values.begin(), found.values.end(),
                                   [&](float value) { return value > 0.999f * most; });
    EXPECT_TRUE(bound) << most;
  }
}

TEST(StrokeCoverage, WhereTheDropCoversAllThereIsNoRoomForAStroke) {
  StreakAtlas atlas = atlas_with(beaded_stroke());
  Image& plain = atlas.layers[0].coverage[0];
  for (float& value : plain.values) value = value > 0 ? 1.0f : 0.0f;
  const Image found = stroke_coverage(atlas, 1).layers[0].coverage[0];
  for (std::size_t i = 0; i < found.values.size(); ++i)
    EXPECT_NEAR(found.values[i], plain.values[i], 1e-6f);
}

TEST(StrokeCoverage, AStrokeWithoutLightAlongItsMiddleIsRefused) {
  StreakStroke ring = {"ring.exr", make_image(41, 30)};
  for (int y = 0; y < 30; ++y) ring.matte.at(0, y) = ring.matte.at(40, y) = 1;
  EXPECT_EQ(message_of([&] { stroke_coverage(atlas_with(ring), 1); }),
            "ring.exr: has no light along its middle; expected a single stroke");
}

TEST(StrokeCoverage, EachSetHasAsManyLayersAsAllStrokesNeed) {
  StreakAtlas atlas = synthetic_atlas(
      {.cell_width_px = 8, .levels = 4, .layers = 4, .path_rows = 60, .margin_rows = 4});
  for (const std::size_t count : {1u, 4u, 5u, 6u}) {
    std::vector<StreakStroke> strokes;
    for (std::size_t i = 0; i < count; ++i)
      strokes.push_back(beaded_stroke(10 + 3 * static_cast<int>(i)));
    atlas.strokes = strokes_of(strokes);
    const int each = shapes_of_set(atlas);
    EXPECT_EQ(each, count <= 4 ? 1 : 2);
    const StreakAtlas shaped = stroke_coverage(atlas, 1);
    ASSERT_EQ(shaped.layers.size(), 4u * static_cast<std::size_t>(each));
    for (int set = 0; set < 4; ++set) {
      for (int i = 0; i < each; ++i) {
        const auto layer = static_cast<std::size_t>(layer_of_shape(set, each, i));
        EXPECT_EQ(shaped.layers[layer].oscillation, set);
        // The same as with this stroke alone.
        StreakAtlas alone = atlas;
        alone.strokes = strokes_of({strokes[layer % count]});
        EXPECT_EQ(
            shaped.layers[layer].coverage[0].values,
            stroke_coverage(alone, 1).layers[static_cast<std::size_t>(set)].coverage[0].values);
      }
    }
  }
  EXPECT_EQ(layer_of_shape(3, 2, 5), 7);
}

TEST(StrokeCoverage, OfTheAtlasNothingElseChanges) {
  const StreakAtlas atlas = atlas_with(beaded_stroke());
  const StreakAtlas shaped = stroke_coverage(atlas, 1);
  EXPECT_TRUE(shaped.lights.empty());
  EXPECT_EQ(shaped.views.size(), atlas.views.size());
  EXPECT_EQ(shaped.pixel_m, atlas.pixel_m);
  EXPECT_EQ(shaped.exposure_s, atlas.exposure_s);
  EXPECT_EQ(shaped.levels, atlas.levels);
  EXPECT_EQ(shaped.cell_width_px, atlas.cell_width_px);
}

}  // namespace
}  // namespace pluvia
