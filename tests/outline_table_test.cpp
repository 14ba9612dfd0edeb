// The table of outlines: units, comments, and what it refuses.
#include "oscillation/outline_table.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

#include <fstream>

namespace pluvia {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::string write_table(const TemporaryFolder& folder, const std::string& text) {
  const std::string file = folder / "outlines.csv";
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

TEST(OutlineTable, EveryColumnIsTakenInItsOwnUnit) {
  const TemporaryFolder folder;
  const Outlines outlines = read_outlines(write_table(folder,
                                                      "# source: a ruler\n# more\n\n"
                                                      "view_azimuth_deg, r_um ,t_ms,theta_deg,"
                                                      "sigma_mm,view_elevation_deg\r\n"
                                                      "90,1600, 2.5 ,-180,0.01,20\r\n"
                                                      "0,1500,0,0,1e-3,-90\n"));
  EXPECT_EQ(outlines.source, "a ruler");
  ASSERT_EQ(outlines.points.size(), 2u);
  const OutlinePoint& p = outlines.points[0];
  // Each value is one multiplication away from the text: two roundings of 1.1e-16.
  EXPECT_DOUBLE_EQ(p.time_s, 2.5e-3);
  EXPECT_DOUBLE_EQ(p.theta_rad, -180 * degree);
  EXPECT_DOUBLE_EQ(p.radius_m, 1.6e-3);
  EXPECT_DOUBLE_EQ(p.sigma_m, 1e-5);
  EXPECT_DOUBLE_EQ(p.view_elevation_rad, 20 * degree);
  EXPECT_DOUBLE_EQ(p.view_azimuth_rad, 90 * degree);
}

TEST(OutlineTable, EveryBadPlaceIsNamed) {
  const TemporaryFolder folder;
  const std::string head = "# source: s\nt_s,theta_deg,r_mm\n";
  const auto complaint = [&](const std::string& text) {
    const std::string file = write_table(folder, text);
    const std::string message = message_of([&] { read_outlines(file); });
    EXPECT_THAT(message, testing::StartsWith(file + ":"));
    EXPECT_THAT(message, testing::HasSubstr("; expected "));
    return message.substr(std::min(message.size(), file.size() + 1));
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"# source: s\nt_s,theta_deg,r\n", "2:15: column \"r\"; expected one of t_s, "},
      {"# source: s\nt_s,t_ms,theta_deg,r_mm\n", "2:5: column t_ms after t_s"},
      {"# source: s\nt_s,r_mm\n0,1\n", "2:1: no column of the theta"},
      {head + "0,0\n", "3:3: 2 values; expected 3"},
      {head + "0,0,1,\n", "3:7: 4 values; expected 3"},
      {head + "0,0,1.6\n0, x,1\n", "4:4: theta_deg = \"x\"; expected a number, -720 .. 720"},
      {head + "0,0,1.6mm\n", "3:5: r_mm = \"1.6mm\""},
      {head + "0,0,nan\n", "3:5: r_mm = \"nan\""},
      {head + "0,0,-1\n", "3:5: r_mm = \"-1\""},
      {head + "0,0,1600\n", "3:5: r_mm = \"1600\"; expected a number, 0.01 .. 20"},
      {head + "inf,0,1\n", "3:1: t_s = \"inf\""},
      {head + "0,,1\n", "3:3: theta_deg = \"\""},
      {head, "3:1: the end"},
      {"", "1:1: the end"},
      {"t_s,theta_deg,r_mm\n0,0,1\n", "1:1: no comment \"# source: ..\""},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_THAT(complaint(text), testing::StartsWith(expected)) << text;
  }
}

TEST(OutlineTable, AFileThatIsNotThereIsSaidToBeMissing) {
  EXPECT_EQ(message_of([] { read_outlines("none.csv"); }),
            "none.csv: cannot read: No such file or directory; expected a table of outlines");
}

}  // namespace
}  // namespace pluvia
