#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/streak_atlas.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(AtlasFiles, AtlasIsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  for (const bool env : {true, false}) {
    const std::string database = folder / (env ? "with" : "without");
    write_database(database, {.env = env, .harmonics = env ? 4 : 0});
    const StreakAtlas atlas = pack_database(database);
    write_atlas(folder / "atlas", atlas);
    const StreakAtlas again = read_atlas(folder / "atlas");
    EXPECT_EQ(again.cell_width_px, atlas.cell_width_px);
    EXPECT_EQ(again.levels, atlas.levels);
    EXPECT_EQ(again.diameter_um, atlas.diameter_um);
    EXPECT_EQ(again.mean_radius_m, atlas.mean_radius_m);
    EXPECT_EQ(again.exposure_s, atlas.exposure_s);
    EXPECT_EQ(again.fall_speed_m_s, atlas.fall_speed_m_s);
    EXPECT_EQ(again.pixel_m, atlas.pixel_m);
    EXPECT_EQ(again.database_sha256, atlas.database_sha256);
    EXPECT_EQ(again.transfer_degree, env ? 1 : -1);
    EXPECT_EQ(again.lights, atlas.lights);
    ASSERT_EQ(again.views.size(), atlas.views.size());
    for (std::size_t i = 0; i < atlas.views.size(); ++i) {
      EXPECT_EQ(again.views[i].elevation_deg, atlas.views[i].elevation_deg);
      EXPECT_EQ(again.views[i].height_px, atlas.views[i].height_px);
      EXPECT_EQ(again.views[i].row_px, atlas.views[i].row_px);
      EXPECT_EQ(again.views[i].path_top_row, atlas.views[i].path_top_row);
      EXPECT_EQ(again.views[i].path_bottom_row, atlas.views[i].path_bottom_row);
    }
    ASSERT_EQ(again.layers.size(), atlas.layers.size());
    for (std::size_t i = 0; i < atlas.layers.size(); ++i) {
      EXPECT_EQ(again.layers[i].oscillation, atlas.layers[i].oscillation);
      EXPECT_EQ(again.layers[i].env.size(), env ? 4u : 0u);
      expect_equal(again.layers[i].point, atlas.layers[i].point);
      expect_equal(again.layers[i].env, atlas.layers[i].env);
      expect_equal(again.layers[i].coverage, atlas.layers[i].coverage);
      EXPECT_EQ(again.layers[i].transfer.size(), env ? 4u : 0u);
      expect_equal(again.layers[i].transfer, atlas.layers[i].transfer);
    }
  }
}

TEST(AtlasFiles, AtlasFilesThatDoNotBelongTogetherAreRefused) {
  const TemporaryFolder folder;
  write_database(folder / "database");
  const StreakAtlas atlas = pack_database(folder / "database");
  const std::string path = folder / "atlas";
  write_atlas(path, atlas);
  const std::string table = read_file(path + "/atlas.json");
  const std::string layer = read_file(path + "/osc02.exr");
  const auto message_with = [&](const std::string& piece, const std::string& replacement) {
    std::string text = table;
    text.replace(text.find(piece), piece.size(), replacement);
    write_file_atomically(path + "/atlas.json", text);
    const std::string message = message_of([&] { read_atlas(path); });
    write_file_atomically(path + "/atlas.json", table);
    return message.substr(path.size() + 1);
  };
  EXPECT_EQ(message_with("\"version\": 1", "\"version\": 2"),
            "atlas.json: version 2; this program reads version 1");
  EXPECT_EQ(message_with("\"cell_width_px\": 8", "\"cell_width_px\": 12"),
            "atlas.json: cell_width_px: 12; expected a power of two");
  EXPECT_EQ(message_with("\"levels\": 4", "\"levels\": 5"),
            "atlas.json: levels: 5; expected an integer 1 .. 4");
  EXPECT_EQ(message_with("\"row_px\": 24", "\"row_px\": 25"),
            "atlas.json: views[1].row_px: 25; expected an integer 24 .. 24");
  EXPECT_EQ(message_with("\"elevation_deg\": 40", "\"elevation_deg\": 0"),
            "atlas.json: views[2].elevation_deg: 0; expected an integer 1 .. 90");
  EXPECT_THAT(
      message_with("\"height_px\": 16", "\"height_px\": 17"),
      StartsWith("osc00.exr: part point_mip0: missing or of another shape; expected 24 x 88"));
  EXPECT_THAT(message_with("\"path_bottom_row\": 28.75", "\"path_bottom_row\": 8.5"),
              HasSubstr("path_bottom_row: 8.5; expected more than path_top_row 8.5"));
  EXPECT_EQ(message_with("\"cell_width_px\": 8", "\"rest_from_sky\": 1, \"cell_width_px\": 8"),
            "atlas.json: rest_from_sky: 1; expected true or false");
  // With fewer levels the views would lie closer together.
  EXPECT_EQ(message_with("\"levels\": 4", "\"levels\": 3"),
            "atlas.json: views[2].row_px: 64; expected an integer 60 .. 60");
  EXPECT_THAT(message_with("osc02.exr", "osc00.exr"),
              StartsWith("osc00.exr: SHA-256 is not that of"));
  write_file_atomically(path + "/osc02.exr", layer.substr(0, layer.size() / 2));
  EXPECT_THAT(message_of([&] { read_atlas(path); }), StartsWith(path + "/osc02.exr: "));
  std::filesystem::remove(path + "/osc02.exr");
  EXPECT_THAT(message_of([&] { read_atlas(path); }),
              HasSubstr("osc02.exr: cannot read: No such file or directory"));
}

TEST(AtlasFiles, NotANumberInAnAtlasIsNotWritten) {
  const TemporaryFolder folder;
  write_database(folder / "database");
  StreakAtlas atlas = pack_database(folder / "database");
  atlas.layers[1].env[2].at(1, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message_of([&] { write_atlas(folder / "atlas", atlas); }),
              HasSubstr("osc02.exr: part env_mip2: pixel (1, 3) channel Y = nan"));
  EXPECT_FALSE(std::filesystem::exists(folder / "atlas/atlas.json"));
}

}  // namespace
}  // namespace pluvia
