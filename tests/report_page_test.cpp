// The report's page in a real browser: chromium, without a window.
#include <filesystem>
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/browser.h"
#include "validate/report.h"

namespace pluvia {
namespace {

// Everything that could make a page wider than a screen: long words, wide pictures, many columns.
Report wide_report() {
  Report report;
  report.headlines = {"frame.composite"};
  report.checks = {{.name = "frame.composite", .value = 0.02, .bound = 0.03, .unit = "relRMSE"},
                   {.name = std::string(80, 'n'), .value = 2, .bound = 1, .why = "too far"}};
  Figure figure{"Frames", "side by side", {}};
  for (int i = 0; i < 3; ++i) {
    figure.panels.push_back({.image = make_image(640, 90, 3), .caption = "frame"});
    figure.panels.push_back({.image = make_image(16, 525), .caption = "streak", .zoom = 2});
  }
  report.figures = {figure};
  const Panel frame = {.image = make_image(640, 90, 3), .caption = std::string(60, 'f')};
  report.comparisons = {
      {.title = "Frames", .unit = "cd/m^2", .picture = frame, .reference = frame}};
  report.plots = {{"cost", "s", "error", true, true, {{"cells", {1, 10}, {2, 1}, {}}}}};
  report.tables = {{"t", std::vector<std::string>(30, "column"), {}}};
  report.commands = {std::string(300, 'c')};
  report.machine = describe_machine();
  return report;
}

class ReportPageTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_browser()) GTEST_SKIP() << "chromium is not installed";
    folder = testing::TempDir() + "report_page_test_" +
             testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    write_report(folder, wide_report());
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string folder;
};

TEST_F(ReportPageTest, LoadsWithoutAWordOnTheConsole) {
  const Browsing seen = browse(folder, "index.html", 1280);
  EXPECT_NE(seen.document.find("1 of 2 checks passed"), std::string::npos);
  EXPECT_EQ(seen.console, "");
}

TEST_F(ReportPageTest, FitsAPhoneAndShowsEveryPicture) {
  // The narrowest window that chromium opens is 500 px: a phone of 390 px is a frame within it. A
  // copy of the page measures itself once its viewer is open, and tells the page around it: by how
  // much it is wider than the frame, and how many pictures the browser could not decode.
  const std::string probe =
      "<script>addEventListener('load', () => setTimeout(() => {"
      "const root = document.documentElement;"
      "parent.postMessage([root.clientWidth, root.scrollWidth, document.images.length,"
      "[...document.images].filter(i => !i.naturalWidth).length,"
      "document.querySelectorAll('.comparison.live').length].join(), '*');}, 5000));</script>";
  write_file_atomically(folder + "/probe.html", read_file(folder + "/index.html") + probe);
  write_file_atomically(
      folder + "/phone.html",
      "<!DOCTYPE html><title>phone</title><iframe src=\"probe.html\" width=390 height=844 "
      "style=\"border:0\"></iframe><script>addEventListener('message', event => {"
      "document.documentElement.dataset.seen = event.data;});</script>");
  const std::string text = browse(folder, "phone.html", 500).document;
  // The scroll bar takes its width of the frame: the first two numbers are equal, 375 or so.
  std::smatch seen;
  ASSERT_TRUE(std::regex_search(text, seen, std::regex("data-seen=\"(\\d+),(\\d+),9,0,1\"")))
      << text.substr(0, 200);
  EXPECT_EQ(seen[1], seen[2]);
  EXPECT_LE(std::stoi(seen[1]), 390);
}

}  // namespace
}  // namespace pluvia
