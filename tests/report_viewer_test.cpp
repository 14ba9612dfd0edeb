// The viewer of the report's page, used by a script as a person would (report_viewer_probe.js), in
// a real browser.
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Imath/half.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/rec709.h"
#include "tests/browser.h"
#include "tests/temporary_folder.h"
#include "validate/report.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

constexpr int width = 64, height = 16;
constexpr double white = 3;

// Neighbours differ; up to five times white; one value is below 0, one no number.
Image judged_picture() {
  Image image = make_image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = static_cast<float>(white * (x % 8) / 7);
      image.at(x, y, 1) = static_cast<float>(white * (y % 8) / 7);
      image.at(x, y, 2) = static_cast<float>(white * 5 * (y * width + x) / (width * height));
    }
  }
  image.at(0, 0, 0) = 1.5f;
  image.at(0, 0, 1) = 0.25f;
  image.at(62, 15, 1) = -1;
  image.at(63, 15, 2) = std::numeric_limits<float>::quiet_NaN();
  return image;
}

Image reference_picture() {
  Image image = judged_picture();
  for (float& value : image.values) value = std::isnan(value) ? 1 : 0.5f * std::abs(value) + 0.125f;
  return image;
}

Report report_of_comparison() {
  Report report;
  Image map = make_image(width, height);
  for (std::size_t i = 0; i < map.values.size(); ++i)
    map.values[i] = 0.001f * static_cast<float>(i);
  report.comparisons = {{.title = "Frames",
                         .text = "One, and what it should be.",
                         .unit = "cd/m^2",
                         .picture = {judged_picture(), white, "ours"},
                         .reference = {reference_picture(), white, "theirs"},
                         .gain = 4,
                         .maps = {{map, 0.5, "error"}}}};
  return report;
}

using Color = std::vector<int>;
using Colors = std::vector<Color>;

// What a screen shows of a picture, channel by channel; magenta where it is no number.
Colors shown(const Image& image, double at_white) {
  Colors colors;
  for (int i = 0; i < width * height; ++i) {
    Color color;
    for (int c = 0; c < 3; ++c) {
      const double v = image.at(i % width, i / width, image.channels == 3 ? c : 0) / at_white;
      if (std::isnan(v)) break;
      color.push_back(static_cast<int>(std::lround(255 * srgb_encoded(std::clamp(v, 0.0, 1.0)))));
    }
    colors.push_back(color.size() == 3 ? color : Color{255, 0, 255});
  }
  return colors;
}

int largest_difference(const Colors& a, const Colors& b) {
  if (a.size() != b.size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[i][c] - b[i][c]));
  }
  return largest;
}

// A half float is off by 2^-11 of itself. A byte is 255 (1.055 v^(1/2.4) - 0.055): it moves by at
// most 255 * 1.055 / 2.4 * 2^-11 = 0.055 of a step, which can change its rounding by 1.
constexpr int of_rounding = 1;

// Of a picture a and its reference a / 2 + 0.125, both over white, shown 4 times: d = 4 |a - b| is
// off by at most 4 * 2^-11 (a + b) = 2^-9 (0.75 d + 0.167), and a byte by 255 * 12.92 of that where
// d is near 0, less elsewhere: 1.1 of a step, which can change its rounding by 2.
constexpr int of_difference = 2;

class ReportViewerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!has_browser()) return;
    const TemporaryFolder folder;
    write_report(folder.path(), report_of_comparison());
    const std::string script = read_file(PLUVIA_SOURCE_DIR "/tests/report_viewer_probe.js");
    write_file_atomically(folder / "probe.html",
                          read_file(folder / "index.html") + "<script>" + script + "</script>");
    const Browsing browsing = browse(folder.path(), "probe.html", 1280);
    console = browsing.console;
    const std::string begin = "<pre id=\"seen\">";
    const std::size_t at = browsing.document.rfind(begin);
    if (at == std::string::npos) return;
    const std::size_t from = at + begin.size();
    std::string text =
        browsing.document.substr(from, browsing.document.find("</pre>", from) - from);
    seen = nlohmann::json::parse(text, nullptr, false);
  }
  void SetUp() override {
    if (!has_browser()) GTEST_SKIP() << "chromium is not installed";
    ASSERT_TRUE(seen.is_object()) << console;
  }

  static Colors colors(const nlohmann::json& list) { return list.get<Colors>(); }

  static nlohmann::json seen;
  static std::string console;
};

nlohmann::json ReportViewerTest::seen;
std::string ReportViewerTest::console;

TEST(PackedPicture, HoldsEveryValueToHalfAFloatsLastBit) {
  Image image = make_image(64, 3, 3);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const auto x = static_cast<float>(i);
    image.values[i] = std::exp(0.05f * x - 20) * (i % 3 == 0 ? -1.0f : 1.0f);
  }
  const PackedPicture packed = pack_picture(image);
  const std::size_t count = 64 * 3;
  std::vector<unsigned char> bytes(2 * 3 * count);
  uLongf size = bytes.size();
  ASSERT_EQ(uncompress(bytes.data(), &size, packed.bytes.data(), packed.bytes.size()), Z_OK);
  ASSERT_EQ(size, bytes.size());
  const double largest = *std::max_element(image.values.begin(), image.values.end());
  for (std::size_t c = 0; c < 3; ++c) {
    std::uint16_t bits = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned char* at = bytes.data() + 2 * count * c + i;
      const int step = at[0] * 256 + at[count];
      bits = static_cast<std::uint16_t>(i % 64 == 0 ? step : bits + step);
      half value;
      value.setBits(bits);
      const double expected = image.values[3 * i + c];
      const double found = std::ldexp(static_cast<double>(value), packed.exponent);
      EXPECT_LE(std::abs(found - expected),
                std::max(std::abs(expected) * 0x1p-11, largest * 0x1p-39))
          << i << " " << c;
    }
  }
}

TEST_F(ReportViewerTest, SaysNothingOnTheConsoleAndNamesAllThatCanBeUsed) {
  EXPECT_EQ(console, "");
  EXPECT_EQ(seen["unnamed"], nlohmann::json::array());
  EXPECT_EQ(seen["stillsHidden"], "none");
}

TEST_F(ReportViewerTest, AtNoStopsTheCanvasShowsWhatThePngShows) {
  const Colors ours = colors(seen["sides"][0]), theirs = colors(seen["sides"][1]);
  EXPECT_LE(largest_difference(ours, colors(seen["stills"][0])), of_rounding);
  EXPECT_LE(largest_difference(theirs, colors(seen["stills"][1])), of_rounding);
  EXPECT_LE(largest_difference(ours, shown(judged_picture(), white)), of_rounding);
}

TEST_F(ReportViewerTest, AStopOfExposureDoublesTheLight) {
  EXPECT_LE(largest_difference(colors(seen["brighter"]), shown(judged_picture(), white / 4)),
            of_rounding);
  EXPECT_LE(largest_difference(colors(seen["darker"]), shown(judged_picture(), white * 8)),
            of_rounding);
}

TEST_F(ReportViewerTest, TheSliderPartsThePicturesAndFollowsHandAndKeys) {
  // 0.3 and 0.7 of the width, 0.1 of the height: pixels 19 and 44 of row 1.
  const Colors ours = shown(judged_picture(), white), theirs = shown(reference_picture(), white);
  EXPECT_LE(largest_difference(colors(seen["slider90"]), {ours[83], ours[108]}), of_rounding);
  EXPECT_LE(largest_difference(colors(seen["slider10"]), {theirs[83], theirs[108]}), of_rounding);
  // Taken to 80 % of the width; the control has steps of half a per cent. A key moves by 2.
  EXPECT_EQ(seen["sliderDragged"], "80");
  EXPECT_EQ(seen["sliderKey"], "78");
}

TEST_F(ReportViewerTest, BothPicturesAreEnlargedAndMovedInStep) {
  for (const auto& places : seen["inStep"]) EXPECT_EQ(places[0], places[1]);
  EXPECT_NE(seen["inStep"][0][0], seen["inStep"][2][0]);
  // Enlarged by 4 the canvas is 16 pixels wide: 16 or 17 squares and nothing between them.
  EXPECT_GE(seen["squaresAcross"], 16);
  EXPECT_LE(seen["squaresAcross"], 17);
  EXPECT_EQ(seen["fitted"], seen["sides"][1]);
}

TEST_F(ReportViewerTest, WheelFingersAndKeysZoom) {
  EXPECT_EQ(seen["wheelPassing"], "x 63");  // the page scrolls
  EXPECT_EQ(seen["wheelHeld"], "x 15");     // 2^(400/200) times, about the left edge
  EXPECT_EQ(seen["pinched"], "x 48");       // 5 times, about 0.7 of the width: 0.7 + 0.29 / 5
  EXPECT_EQ(seen["keyFits"], "x 63");
}

TEST_F(ReportViewerTest, TheReadoutGivesTheValuesOfBothPictures) {
  EXPECT_EQ(seen["readout"], "x 0, y 0: ours 1.5 0.25 0 cd/m^2; theirs 0.875 0.25 0.125 cd/m^2");
}

TEST_F(ReportViewerTest, FlickerWaitsForTheButton) {
  EXPECT_EQ(seen["flickerStill"], "ours");
  EXPECT_EQ(seen["flickerSwapped"][0], "theirs");
  EXPECT_LE(
      largest_difference(colors(seen["flickerSwapped"][1]), shown(reference_picture(), white)),
      of_rounding);
  EXPECT_EQ(seen["flickerPlayed"], "theirs");
  EXPECT_EQ(seen["flickerPressed"], "false");
}

TEST_F(ReportViewerTest, DifferencesAndMapsShowWhatTheirPngShows) {
  EXPECT_LE(largest_difference(colors(seen["signed"]), colors(seen["stills"][2])), of_difference);
  EXPECT_EQ(seen["reset"], seen["signed"]);
  EXPECT_LE(largest_difference(colors(seen["map"]), colors(seen["stills"][3])), of_rounding);
  Image absolute = judged_picture();
  const Image minus = reference_picture();
  for (std::size_t i = 0; i < absolute.values.size(); ++i) {
    absolute.values[i] = std::abs(absolute.values[i] - minus.values[i]);
  }
  EXPECT_LE(largest_difference(colors(seen["absolute"]), shown(absolute, white / 4)),
            of_difference);
  EXPECT_LE(largest_difference(colors(seen["absoluteLess"]), shown(absolute, white * 2)),
            of_difference);
}

}  // namespace
}  // namespace pluvia
