#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"
#include "atlas/streak_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Manifest sample_manifest() {
  Manifest manifest = {
      .preset = "gn2006",
      .parameters = R"({"cone_half_angle_deg":5.0,"orders":[0,1,2,3],"index":1.333})",
      .seed = 18446744073709551615ull,
      .instruction_set = "avx512",
      .mean_radius_m = 0.1 + 0.2,
      .exposure_s = 1.0 / 60,
      .fall_speed_m_s = 8.49,
      .pixel_m = 1.6e-3 / 5.6};
  for (const int view : {-20, 0, 80}) {
    manifest.shards.push_back(
        {.key = {.diameter_um = 3200, .oscillation = 0, .view_elevation_deg = view},
         .file = "shards/x.exr",
         .sha256 = sha256("x"),
         .width_px = 16,
         .height_px = 525,
         .path_top_row = 8.5,
         .path_bottom_row = 504 + 1.0 / 3,
         .images = {"light_v+10_h010", "coverage"},
         .estimated_relative_error = {0.013, 1e-300}});
  }
  return manifest;
}

// The manifest's text with one piece replaced, read again: the message.
std::string message_with(const std::string& piece, const std::string& replacement) {
  const TemporaryFolder folder;
  write_manifest(folder.path(), sample_manifest());
  std::string text = read_file(folder / "manifest.json");
  const std::size_t place = text.find(piece);
  EXPECT_NE(place, std::string::npos) << piece;
  text.replace(place, piece.size(), replacement);
  write_file_atomically(folder / "manifest.json", text);
  const std::string message = message_of([&] { read_manifest(folder.path()); });
  EXPECT_THAT(message, StartsWith(folder / "manifest.json"));
  return message.substr(folder.path().size() + 1);
}

TEST(Manifest, ManifestIsReadBackExactly) {
  const TemporaryFolder folder;
  const Manifest manifest = sample_manifest();
  write_manifest(folder.path(), manifest);
  const std::string text = read_file(folder / "manifest.json");
  EXPECT_THAT(
      text,
      StartsWith(
          "{\n  \"version\": 1,\n  \"preset\": \"gn2006\",\n  \"parameters\": {\n    \"cone"));
  const Manifest again = read_manifest(folder.path());
  EXPECT_EQ(again.preset, manifest.preset);
  EXPECT_EQ(again.parameters, manifest.parameters);  // the keys keep their order
  EXPECT_EQ(again.seed, manifest.seed);
  EXPECT_EQ(again.instruction_set, manifest.instruction_set);
  EXPECT_EQ(again.mean_radius_m, manifest.mean_radius_m);
  EXPECT_EQ(again.exposure_s, manifest.exposure_s);
  EXPECT_EQ(again.fall_speed_m_s, manifest.fall_speed_m_s);
  EXPECT_EQ(again.pixel_m, manifest.pixel_m);
  ASSERT_EQ(again.shards.size(), manifest.shards.size());
  for (std::size_t i = 0; i < again.shards.size(); ++i) {
    EXPECT_EQ(again.shards[i].key, manifest.shards[i].key);
    EXPECT_EQ(again.shards[i].file, manifest.shards[i].file);
    EXPECT_EQ(again.shards[i].sha256, manifest.shards[i].sha256);
    EXPECT_EQ(again.shards[i].width_px, manifest.shards[i].width_px);
    EXPECT_EQ(again.shards[i].height_px, manifest.shards[i].height_px);
    EXPECT_EQ(again.shards[i].path_top_row, manifest.shards[i].path_top_row);
    EXPECT_EQ(again.shards[i].path_bottom_row, manifest.shards[i].path_bottom_row);
    EXPECT_EQ(again.shards[i].images, manifest.shards[i].images);
    EXPECT_EQ(again.shards[i].estimated_relative_error,
              manifest.shards[i].estimated_relative_error);
  }
  write_manifest(folder.path(), again);
  EXPECT_EQ(read_file(folder / "manifest.json"), text);
}

TEST(Documents, NamesThatAreNoUtf8AreReplacedAndNotRefused) {
  EXPECT_EQ(document_text({{"file", "caf\xe9.png"}}, 1),
            "{\n \"file\": \"caf\xef\xbf\xbd.png\"\n}\n");
}

TEST(Manifest, ManifestOfAnotherVersionOrShapeIsRefusedWithItsKey) {
  EXPECT_EQ(message_with("\"version\": 1", "\"version\": 3"),
            "manifest.json: version 3; this program reads version 1");
  EXPECT_EQ(message_with("\"version\": 1", "\"version\": \"1\""),
            "manifest.json: version \"1\"; this program reads version 1");
  EXPECT_EQ(message_with("\"version\": 1,", ""),
            "manifest.json: version: missing; expected this key");
  EXPECT_EQ(message_with("\"gn2006\"", "2006"), "manifest.json: preset: 2006; expected a string");
  EXPECT_EQ(message_with("18446744073709551615", "-1"),
            "manifest.json: seed: -1; expected an integer 0 .. 2^64 - 1");
  EXPECT_EQ(message_with("8.49", "0"), "manifest.json: fall_speed_m_s: 0; expected a number > 0");
  EXPECT_EQ(message_with("\"height_px\": 525", "\"height_px\": 525.5"),
            "manifest.json: shards[0].height_px: 525.5; expected an integer 1 .. 1048576");
  EXPECT_EQ(message_with("\"height_px\": 525", "\"height_px\": 99999999999999999999"),
            "manifest.json: shards[0].height_px: 1e+20; expected an integer 1 .. 1048576");
  EXPECT_EQ(message_with("\"height_px\": 525,", ""),
            "manifest.json: shards[0].height_px: missing; expected this key");
  EXPECT_EQ(message_with("0.013,", ""),
            "manifest.json: shards[0].estimated_relative_error: 1 numbers; "
            "expected one for each of 2 images");
  EXPECT_EQ(message_with("\"view_elevation_deg\": -20", "\"view_elevation_deg\": 0"),
            "manifest.json: shards[1]: d3200_osc00_v+00 after d3200_osc00_v+00; expected ascending "
            "diameter, oscillation, view, each once");
  EXPECT_EQ(
      message_with("\"sha256\": \"", "\"sha256\": \"0"),
      "manifest.json: shards[0].sha256: \"0" + sha256("x") + "\"; expected 64 hexadecimal digits");
  // Line 2 has two spaces of indent, then the damage in column 3.
  EXPECT_THAT(message_with("\"version\"", "version"), StartsWith("manifest.json:2:3: not JSON: "));
  EXPECT_THAT(message_with("8.49", "1e999"), StartsWith("manifest.json: not JSON: "));
}

TEST(Manifest, EveryTruncatedManifestIsRefused) {
  const TemporaryFolder folder;
  write_manifest(folder.path(), sample_manifest());
  const std::string text = read_file(folder / "manifest.json");
  for (std::size_t length = 0; length + 2 < text.size(); length += 37) {
    std::ofstream(folder / "manifest.json") << text.substr(0, length);
    EXPECT_THAT(message_of([&] { read_manifest(folder.path()); }),
                StartsWith((folder / "manifest.json") + ":"))
        << length << " bytes";
  }
}

TEST(Manifest, ManifestThatCouldNotBeReadBackIsNotWritten) {
  const TemporaryFolder folder;
  Manifest manifest = sample_manifest();
  manifest.shards[1].estimated_relative_error[0] = std::nan("");
  EXPECT_EQ(message_of([&] { write_manifest(folder.path(), manifest); }),
            (folder / "manifest.json") +
                ": shards[1].estimated_relative_error[0]: null; expected a number");
  manifest = sample_manifest();
  manifest.parameters = "[1]";
  EXPECT_THAT(message_of([&] { write_manifest(folder.path(), manifest); }),
              HasSubstr("manifest.json: parameters: not an object"));
  manifest.parameters = "{";
  EXPECT_THAT(message_of([&] { write_manifest(folder.path(), manifest); }),
              HasSubstr("manifest.json: parameters:1:2: not JSON"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Manifest, ShardIsWholeOnlyWithTheBytesOfTheRecord) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "bytes");
  EXPECT_TRUE(shard_is_whole(folder.path(), {.file = "a", .sha256 = sha256("bytes")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = "a", .sha256 = sha256("byte")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = "b", .sha256 = sha256("bytes")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = ".", .sha256 = sha256("")}));
}

}  // namespace
}  // namespace pluvia