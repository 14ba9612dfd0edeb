#include "validate/report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

class ReportTest : public testing::Test {
 protected:
  void SetUp() override {
    folder = testing::TempDir() + "report_test_" +
             testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string page() const { return read_file(folder + "/index.html"); }
  nlohmann::json json() const { return nlohmann::json::parse(read_file(folder + "/report.json")); }

  std::string folder;
};

Check good_check() {
  return {.name = "sphere.energy.p2",
          .value = 0.001,
          .bound = 0.005,
          .measured = 0.04505,
          .expected = 0.045005,
          .uncertainty = 2e-5,
          .unit = "relative",
          .why = "closed form"};
}

Image picture(int width, int height, int channels, float value) {
  Image image = make_image(width, height, channels);
  for (float& v : image.values) v = value;
  return image;
}

// A report with one of everything, and hostile text in each place that takes text.
Report full_report(const std::string& text) {
  Report report;
  report.checks = {good_check(), {.name = text, .unit = text, .why = text}};
  const Panel panel = {.image = picture(8, 4, 3, 0.5f), .caption = text};
  const Panel map = {.image = picture(8, 4, 1, 0.5f), .caption = text};
  report.comparisons = {{text, text, text, panel, panel, 1, {map}}};
  report.figures = {{text, text, {panel}}};
  report.plots = {{text, text, text, false, false, {{text, {1, 2}, {3, 4}, {0.1, 0.1}}}}};
  report.tables = {{text, {text}, {{text}}}};
  report.timings_s = {{text, 1.5}};
  report.machine = {{text, text}};
  report.seeds = {{text, text}};
  report.commands = {text};
  report.skipped = {text};
  report.not_covered = {text};
  report.headlines = {text, "not there " + text};
  return report;
}

TEST_F(ReportTest, JsonHoldsEveryFieldOfTheSchema) {
  Report report;
  report.checks = {good_check()};
  report.timings_s = {{"trace", 1.5}, {"trace", 0.25}, {"pack", 3}};
  report.machine = {{"cores", "2"}};
  report.seeds = {{"drops", "7"}};
  report.skipped = {"video"};
  report.not_covered = {"shadows"};
  report.commands = {"pluvia pack a", "pluvia validate"};
  write_report(folder, report);
  const nlohmann::json root = json();
  EXPECT_EQ(root.at("version"), 1);
  const nlohmann::json expected = {
      {"name", "sphere.energy.p2"}, {"value", 0.001},     {"bound", 0.005}, {"measured", 0.04505},
      {"expected", 0.045005},       {"unit", "relative"}, {"pass", true},   {"uncertainty", 2e-5},
      {"why", "closed form"}};
  EXPECT_EQ(root.at("checks"), nlohmann::json::array({expected}));
  EXPECT_EQ(root.at("timings_s"), (nlohmann::json{{"trace", 1.75}, {"pack", 3.0}}));
  EXPECT_EQ(root.at("machine"), (nlohmann::json{{"cores", "2"}}));
  EXPECT_EQ(root.at("seeds"), (nlohmann::json{{"drops", "7"}}));
  EXPECT_EQ(root.at("skipped"), (nlohmann::json{"video"}));
  EXPECT_EQ(root.at("not_covered"), (nlohmann::json{"shadows"}));
  EXPECT_EQ(root.at("commands"), (nlohmann::json{"pluvia pack a", "pluvia validate"}));
}

TEST(Check, PassesUpToItsBoundAndNeverWithANumberThatIsNone) {
  EXPECT_TRUE(passes({.value = 1, .bound = 1}));
  EXPECT_TRUE(passes({}));
  EXPECT_FALSE(passes({.value = std::nextafter(1.0, 2.0), .bound = 1}));
  EXPECT_FALSE(passes({.value = -1e-9, .bound = 1}));  // a deviation is never negative
  for (const double broken : {nan, infinity, -infinity}) {
    EXPECT_FALSE(passes({.value = broken, .bound = 1})) << broken;
    EXPECT_FALSE(passes({.value = 0, .bound = broken})) << broken;
    EXPECT_FALSE(passes({.bound = 1, .measured = broken})) << broken;
    EXPECT_FALSE(passes({.bound = 1, .expected = broken})) << broken;
    EXPECT_FALSE(passes({.bound = 1, .uncertainty = broken})) << broken;
  }
}

TEST_F(ReportTest, ANumberThatIsNoneIsNullInJsonAndToldInThePage) {
  Report report;
  report.checks = {{.name = "a", .value = nan, .bound = 1, .measured = infinity}, good_check()};
  write_report(folder, report);
  const nlohmann::json check = json().at("checks").at(0);
  EXPECT_TRUE(check.at("value").is_null());
  EXPECT_TRUE(check.at("measured").is_null());
  EXPECT_EQ(check.at("pass"), false);
  EXPECT_NE(page().find("1 of 2 checks passed"), std::string::npos);
  EXPECT_NE(page().find("not finite"), std::string::npos);
  EXPECT_EQ(page().find(">nan<"), std::string::npos);
}

TEST_F(ReportTest, TextIsNeverReadAsMarkupNorAsAPlaceholder) {
  // Single and double quotes leave an attribute, "{{machine}}" is the name of a part of the page,
  // the line end and the quote would end a plot's command.
  const std::string hostile = "<script>alert(1)</script> \"'&{{machine}}\n`id`";
  write_report(folder, full_report(hostile));
  const std::string text = page();
  const auto tags_of = [](const std::string& page_text) {
    const std::regex tag("<(script|/script|template)");
    return std::distance(std::sregex_iterator(page_text.begin(), page_text.end(), tag), {});
  };
  write_report(folder, full_report("plain"));
  EXPECT_EQ(tags_of(text), tags_of(page()));
  EXPECT_NE(text.find("&lt;script&gt;alert(1)&lt;/script&gt; &quot;&#39;&amp;{{machine}}"),
            std::string::npos);
  write_report(folder, full_report(hostile));
  EXPECT_EQ(json().at("commands").at(0), hostile);
}

TEST_F(ReportTest, BytesThatAreNoTextDoNotStopTheReport) {
  Report report;
  report.commands = {"pluvia \xff\xfe"};
  write_report(folder, report);
  EXPECT_EQ(json().at("commands").at(0), "pluvia \uFFFD\uFFFD");
}

TEST_F(ReportTest, PageAsksNothingOfTheNetworkNorOfOtherFiles) {
  Report report = full_report("plain");
  report.machine = describe_machine();
  write_report(folder, report);
  const std::string text = page();
  const std::regex link("(?:src|href|srcset|action|data)\\s*=\\s*[\"']?([^\"'>\\s]{0,40})");
  int pictures = 0;
  for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i) {
    const std::string target = (*i)[1];
    const bool inside = target.rfind("data:image/png;base64,", 0) == 0 || target[0] == '#';
    EXPECT_TRUE(inside) << target;
    pictures += target[0] == 'd';
  }
  EXPECT_EQ(pictures, 5);  // four of the comparison: two, their difference, a map
  EXPECT_EQ(text.find("url("), std::string::npos);
  EXPECT_EQ(text.find("@import"), std::string::npos);
  EXPECT_EQ(text.find("{{"), std::string::npos) << "a placeholder was left";
}

// Bytes that no packing makes smaller.
Image noise(int width, int height, unsigned seed) {
  Image image = make_image(width, height, 3);
  std::minstd_rand random(seed);
  for (float& v : image.values) v = static_cast<float>(random() % 65536) / 65536;
  return image;
}

TEST_F(ReportTest, PicturesThatThePageHasNoRoomForAreListedInstead) {
  // Noise of 1000 x 1000 pixels: 3 MB as PNG, 4 MB in base64 (8 bits in 6). As half floats 15 of 16
  // bits are noise, 7.5 MB at least. Two, their difference (one channel as red and blue) and their
  // half floats have no room in 15 MB; a figure of four has none either, one of one has.
  Report report;
  const Panel a = {.image = noise(1000, 1000, 1)}, b = {.image = noise(1000, 1000, 2)};
  report.comparisons = {{.title = "twins", .picture = a, .reference = b}};
  report.figures = {{"crowd", "", {a, a, a, a}}, {"dot", "", {{.image = picture(1, 1, 1, 1)}}}};
  write_report(folder, report);
  const std::string text = page();
  EXPECT_LE(text.size(), page_bytes);
  EXPECT_NE(text.find("<li>twins, at other exposures: "), std::string::npos);
  EXPECT_NE(text.find("<li>crowd: "), std::string::npos);
  EXPECT_NE(text.find("<h3>twins</h3>"), std::string::npos);
  EXPECT_NE(text.find("<h3>dot</h3>"), std::string::npos);
  EXPECT_EQ(text.find("<h3>crowd</h3>"), std::string::npos);
  EXPECT_EQ(text.find("packed-0"), std::string::npos);
}

TEST_F(ReportTest, PicturesFillThePageAlmostToItsEnd) {
  // Figures of 300 x 300 pixels of noise: 0.36 MB each in base64, 60 of them 22 MB. What is left is
  // less than one, and 0.1 MB for what is written after the pictures.
  Report report;
  const Panel panel = {.image = noise(300, 300, 1)};
  for (int i = 0; i < 60; ++i) report.figures.push_back({"noise", "", {panel}});
  write_report(folder, report);
  EXPECT_LE(page().size(), page_bytes);
  EXPECT_GE(page().size(), page_bytes - 500'000);
}

TEST_F(ReportTest, APictureInTwoComparisonsIsPackedOnce) {
  Report report;
  const Panel a = {.image = noise(8, 4, 1)}, b = {.image = noise(8, 4, 2)};
  report.comparisons = {{.title = "one", .picture = a, .reference = b},
                        {.title = "two", .picture = b, .reference = a}};
  write_report(folder, report);
  const std::string text = page();
  const std::regex packed("id=\"packed-");
  EXPECT_EQ(std::distance(std::sregex_iterator(text.begin(), text.end(), packed), {}), 2);
}

TEST(Comparison, PicturesThatCannotBeLaidOverEachOtherAreRefused) {
  PagePictures pictures;
  const Panel a = {.image = picture(4, 3, 3, 1)}, gray = {.image = picture(4, 3, 1, 1)};
  const Panel wide = {.image = picture(5, 3, 3, 1)};
  const Panel bright = {.image = picture(4, 3, 3, 1), .white = 2};
  const auto refused = [&](const Comparison& comparison) {
    EXPECT_THROW(comparison_html(comparison, pictures), std::runtime_error);
  };
  EXPECT_NO_THROW(comparison_html({.picture = a, .reference = a, .maps = {gray}}, pictures));
  refused({.picture = a, .reference = wide});
  refused({.picture = a, .reference = gray});
  refused({.picture = a, .reference = bright});
  refused({.picture = a, .reference = a, .maps = {a}});
  refused({.picture = a, .reference = a, .maps = {{.image = picture(5, 3, 1, 1)}}});
  for (const double gain : {0.0, -1.0, 0.5, 3.0, 2048.0, nan, infinity}) {
    refused({.picture = a, .reference = a, .gain = gain});
  }
}

TEST_F(ReportTest, EveryCheckLeadsToHowItIsComputedAndBack) {
  Report report;
  report.checks = {good_check(), {.name = "a b", .value = 2, .bound = 1, .why = "by a rule"}};
  write_report(folder, report);
  const std::string text = page();
  for (const std::string name : {"sphere.energy.p2", "a-b"}) {
    for (const char* kind : {"check-", "how-"}) {
      EXPECT_NE(text.find("id=\"" + (kind + name) + "\""), std::string::npos) << kind << name;
      EXPECT_NE(text.find("href=\"#" + (kind + name) + "\""), std::string::npos) << kind << name;
    }
  }
  // What failed comes before what passed, and both before the table.
  const std::size_t failed = text.find("href=\"#group-a-b\"");
  const std::size_t trusted = text.find("href=\"#group-sphere\"");
  EXPECT_LT(text.find("<li><a class=\"name\" href=\"#check-a-b\">"), failed);
  EXPECT_LT(failed, trusted);
  EXPECT_LT(trusted, text.find("<table"));
}

TEST_F(ReportTest, VideoIsShownOnlyWhereItIs) {
  Report report;
  report.video = "rain.mp4";
  write_report(folder, report);
  EXPECT_EQ(page().find("<video"), std::string::npos);
  EXPECT_NE(page().find("video rain.mp4: not there"), std::string::npos);
  write_file_atomically(folder + "/rain.mp4", "x");
  write_report(folder, report);
  EXPECT_NE(page().find("<video controls loop muted playsinline preload=\"metadata\" "
                        "src=\"rain.mp4\">"),
            std::string::npos);
}

TEST_F(ReportTest, APlotIsDrawnOrListedWithTheReason) {
  Report report;
  report.plots = {
      {"cost", "s", "error", true, true, {{"cells", {1, 10, nan, -1}, {2, 1, 1, 1}, {}}}},
      {"void", "s", "error", false, true, {{"cells", {1}, {0}, {}}}}};
  write_report(folder, report);
  const std::string text = page();
  EXPECT_NE(text.find("plot &quot;void&quot;: no finite point to draw"), std::string::npos);
  const bool drawn = text.find("<svg") != std::string::npos;
  const bool missing =
      text.find("plot &quot;cost&quot;: gnuplot is not installed") != std::string::npos;
  EXPECT_NE(drawn, missing);
}

TEST(Plot, CurvesOfUnequalLengthAreRefused) {
  EXPECT_THROW(draw_plot({.title = "a", .curves = {{"c", {1, 2}, {1}, {}}}}), std::runtime_error);
  EXPECT_THROW(draw_plot({.title = "a", .curves = {{"c", {1}, {1}, {1, 2}}}}), std::runtime_error);
  const Curve half_a_bar = {.label = "c", .x = {1}, .y = {1}, .x_low = {0.5}};
  EXPECT_THROW(draw_plot({.title = "a", .curves = {half_a_bar}}), std::runtime_error);
}

TEST(Plot, HasEveryStyleOfCurveWithAndWithoutBars) {
  Plot plot = {.title = "a", .log_x = true, .log_y = true};
  for (const auto style :
       {CurveStyle::joined, CurveStyle::points, CurveStyle::line, CurveStyle::rings}) {
    plot.curves.push_back({.label = "plain", .x = {1, 2}, .y = {3, 4}, .style = style});
    Curve bars = plot.curves.back();
    bars.label = "barred", bars.y_error = {1, 1};
    plot.curves.push_back(bars);
    bars.x_low = {0.5, 1.5}, bars.x_high = {1.5, 3};
    plot.curves.push_back(bars);
  }
  const PlotDrawing drawing = draw_plot(plot);
  if (drawing.why_not.find("not installed") != std::string::npos) GTEST_SKIP() << drawing.why_not;
  EXPECT_EQ(drawing.why_not, "");
  EXPECT_NE(drawing.svg.find("barred"), std::string::npos);
}

TEST(Panel, TellsWhatIsWhiteAndHowManyPixelsAreNoNumbers) {
  Panel panel{.image = picture(4, 3, 1, 2), .white = 5, .caption = "frame", .zoom = 3};
  panel.image.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  const std::string text = panel_html(panel);
  EXPECT_NE(text.find("white = 5, \u00d73, 1 pixels not finite"), std::string::npos) << text;
  EXPECT_NE(text.find("width=\"12\" height=\"9\" class=\"pixels\""), std::string::npos) << text;
  panel.signed_difference = true;
  EXPECT_NE(panel_html(panel).find("red +5, blue \u22125"), std::string::npos);
}

TEST(Panel, PicturesThatCannotBeShownAreRefused) {
  const Image good = picture(2, 2, 1, 1);
  EXPECT_NO_THROW(panel_html({.image = good}));
  EXPECT_THROW(panel_html({.image = {}}), std::runtime_error);
  EXPECT_THROW(panel_html({.image = picture(2, 2, 2, 1)}), std::runtime_error);
  EXPECT_THROW(panel_html({.image = picture(2, 2, 3, 1), .signed_difference = true}),
               std::runtime_error);
  EXPECT_THROW(panel_html({.image = good, .white = 0}), std::runtime_error);
  EXPECT_THROW(panel_html({.image = good, .white = nan}), std::runtime_error);
  EXPECT_THROW(panel_html({.image = good, .zoom = 0}), std::runtime_error);
}

TEST_F(ReportTest, ARefusedReportLeavesTheOldOneWhole) {
  Report report;
  report.commands = {"the old command"};
  write_report(folder, report);
  report.commands = {"the new command"};
  report.tables = {{"cost", {"pass"}, {{"rain", "3 ms"}}}};  // a cell too many
  EXPECT_THROW(write_report(folder, report), std::runtime_error);
  EXPECT_EQ(json().at("commands").at(0), "the old command");
  EXPECT_NE(page().find("the old command"), std::string::npos);
}

TEST_F(ReportTest, WritingLeavesNoTemporaryFileAndReplacesTheOldReport) {
  Report report;
  report.commands = {"the old command"};
  write_report(folder, report);
  report.commands = {"the new command"};
  write_report(folder, report);
  EXPECT_EQ(page().find("the old command"), std::string::npos);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"index.html", "report.json"}));
}

TEST(Machine, IsDescribedWithNoBlank) {
  const auto machine = describe_machine();
  EXPECT_GE(machine.size(), 10u);
  for (const auto& [name, text] : machine) EXPECT_FALSE(text.empty()) << name;
}

TEST(ReportVerdict, NamesTheLargestRelativeErrorThatWasFound) {
  Report report;
  report.checks = {{.name = "a.small", .value = 0.02, .bound = 0.03, .unit = "relative"},
                   {.name = "a.large", .value = 0.41, .bound = 0.45, .unit = "relative RMSE"},
                   {.name = "a.other_unit", .value = 3, .bound = 4, .unit = "standard errors"}};
  const std::string summary = summary_html(report);
  EXPECT_NE(summary.find("The largest relative error found is 41 % (<a href=\"#how-a.large\">"),
            std::string::npos)
      << summary.substr(0, 600);
  report.checks = {report.checks[2]};
  EXPECT_EQ(summary_html(report).find("largest relative error"), std::string::npos);
}

}  // namespace
}  // namespace pluvia
