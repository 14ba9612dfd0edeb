// The report's page in a real browser: chromium, without a window.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
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
  report.plots = {{"cost", "s", "error", true, true, {{"cells", {1, 10}, {2, 1}, {}}}}};
  report.tables = {{"t", std::vector<std::string>(30, "column"), {}}};
  report.commands = {std::string(300, 'c')};
  report.machine = describe_machine();
  return report;
}

class ReportPageTest : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium >/dev/null 2>&1") != 0) {
      GTEST_SKIP() << "chromium is not installed";
    }
    folder = testing::TempDir() + "report_page_test_" +
             testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    write_report(folder, wide_report());
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  // What the browser's document looks like once loaded; its messages go to FOLDER/log.
  std::string document(int width_px, const std::string& file) const {
    const std::string command = fmt::format(
        "timeout 60 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
        "--disable-background-networking --disable-component-update --disable-sync "
        "--enable-logging=stderr --user-data-dir='{0}/profile' --window-size={1},2000 --dump-dom "
        "'file://{0}/{2}' >'{0}/document' 2>'{0}/log'",
        folder, width_px, file);
    EXPECT_EQ(std::system(command.c_str()), 0);
    return read_file(folder + "/document");
  }

  std::string folder;
};

TEST_F(ReportPageTest, LoadsWithoutAWordOnTheConsole) {
  EXPECT_NE(document(1280, "index.html").find("1 of 2 checks passed"), std::string::npos);
  EXPECT_EQ(read_file(folder + "/log").find("CONSOLE"), std::string::npos)
      << read_file(folder + "/log");
}

TEST_F(ReportPageTest, FitsANarrowWindowAndShowsEveryPicture) {
  // The narrowest window chromium opens is 500 px: below the 46rem where the phone's layout begins.
  // A copy of the page measures itself: by how much it is wider than the window, and how many
  // pictures the browser could not decode.
  const std::string probe =
      "<script>const root = document.documentElement;"
      "root.dataset.excess = root.scrollWidth - root.clientWidth;"
      "root.dataset.broken = [...document.images].filter(i => !i.naturalWidth).length;</script>";
  write_file_atomically(folder + "/probe.html", read_file(folder + "/index.html") + probe);
  const std::string text = document(500, "probe.html");
  EXPECT_NE(text.find("data-excess=\"0\""), std::string::npos) << text.substr(0, 200);
  EXPECT_NE(text.find("data-broken=\"0\""), std::string::npos) << text.substr(0, 200);
}

}  // namespace
}  // namespace pluvia
