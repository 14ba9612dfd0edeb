#include "atlas/streak_database.h"

#include <OpenEXR/ImfThreading.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

StreakImage random_streak(std::mt19937& random, int count) {
  std::exponential_distribution<float> value(3);
  StreakImage image;
  for (int i = 0; i < count; ++i) {
    image.mean.push_back(value(random));
    image.variance.push_back(value(random) * 1e-4f);
  }
  return image;
}

Shard random_shard(unsigned seed) {
  std::mt19937 random(seed);
  Shard shard = {.key = {.diameter_um = 3200, .oscillation = 3, .view_elevation_deg = -20},
                 .width_px = 8,
                 .height_px = 33,  // two ZIP chunks of 16 rows and one of 1
                 .lights = {{-90, 170}, {10, 10}, {10, 170}}};
  const int count = shard.width_px * shard.height_px;
  for (std::size_t i = 0; i < shard.lights.size(); ++i) {
    shard.light.push_back(random_streak(random, count));
  }
  shard.env = random_streak(random, count);
  shard.coverage = random_streak(random, count);
  return shard;
}

// Plain writing: damaged files are many, and none of them is worth a sync of the disk.
void put_file(const std::string& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

const std::string shard_file = "d3200_osc03_v-20.exr";

void expect_equal(const StreakImage& a, const StreakImage& b, const char* what) {
  EXPECT_EQ(a.mean, b.mean) << what;
  EXPECT_EQ(a.variance, b.variance) << what;
}

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

TEST(StreakDatabase, The2006DirectionsAre74InAscendingOrder) {
  const std::vector<LightDirection> lights = gn2006_light_directions();
  ASSERT_EQ(lights.size(), 74u);  // 8 elevations x 9 azimuths + 2 poles
  EXPECT_EQ(lights.front(), (LightDirection{-90, 170}));
  EXPECT_EQ(lights[1], (LightDirection{-70, 10}));
  EXPECT_EQ(lights[36], (LightDirection{-10, 170}));
  EXPECT_EQ(lights[37], (LightDirection{10, 10}));
  EXPECT_EQ(lights.back(), (LightDirection{90, 170}));
  for (std::size_t i = 1; i < lights.size(); ++i) {
    EXPECT_LT(std::pair(lights[i - 1].elevation_deg, lights[i - 1].azimuth_deg),
              std::pair(lights[i].elevation_deg, lights[i].azimuth_deg));
  }
}

TEST(StreakDatabase, NamesOfShardsCarrySignsAndLeadingZeros) {
  EXPECT_EQ(shard_name({.diameter_um = 3200, .oscillation = 3, .view_elevation_deg = 20}),
            "d3200_osc03_v+20");
  EXPECT_EQ(shard_name({.diameter_um = 800, .oscillation = 12, .view_elevation_deg = -80}),
            "d0800_osc12_v-80");
  EXPECT_EQ(shard_name({.diameter_um = 3200, .oscillation = 0, .view_elevation_deg = 0}),
            "d3200_osc00_v+00");
}

TEST(StreakDatabase, ShardIsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  Shard shard = random_shard(1);
  shard.light[1].mean[5] = 0;
  shard.light[1].mean[6] = 1e-42f;  // denormal
  const std::string hash = write_shard(folder / shard_file, shard);
  EXPECT_EQ(hash, sha256(read_file(folder / shard_file)));
  const Shard again = read_shard(folder / shard_file);
  EXPECT_EQ(again.key, shard.key);
  EXPECT_EQ(again.width_px, shard.width_px);
  EXPECT_EQ(again.height_px, shard.height_px);
  ASSERT_EQ(again.lights, shard.lights);
  for (std::size_t i = 0; i < shard.light.size(); ++i)
    expect_equal(again.light[i], shard.light[i], "light");
  expect_equal(again.env, shard.env, "env");
  expect_equal(again.coverage, shard.coverage, "coverage");
}

TEST(StreakDatabase, ShardWithoutEnvironmentOrLightsIsReadBack) {
  const TemporaryFolder folder;
  Shard shard = random_shard(2);
  shard.env = {};
  write_shard(folder / shard_file, shard);
  EXPECT_TRUE(read_shard(folder / shard_file).env.mean.empty());
  EXPECT_EQ(read_shard(folder / shard_file).light.size(), 3u);
  shard.lights = {};
  shard.light = {};
  write_shard(folder / shard_file, shard);
  expect_equal(read_shard(folder / shard_file).coverage, shard.coverage, "coverage");
}

TEST(StreakDatabase, BytesOfAShardDependOnTheShardAlone) {
  const TemporaryFolder folder;
  const Shard shard = random_shard(3);
  const int before = Imf::globalThreadCount();
  const std::string once = write_shard(folder / "a.exr", shard);
  const std::string twice = write_shard(folder / shard_file, shard);
  EXPECT_EQ(once, twice);
  for (const int threads : {1, 2}) {
    Imf::setGlobalThreadCount(threads);
    EXPECT_EQ(write_shard(folder / "b.exr", shard), once) << threads << " threads";
  }
  Imf::setGlobalThreadCount(before);
  EXPECT_NE(write_shard(folder / "c.exr", random_shard(4)), once);
}

TEST(StreakDatabase, ValuesThatNoStreakHasAreRefusedWithPartAndPixel) {
  const TemporaryFolder folder;
  const std::string file = folder / shard_file;
  const auto message = [&](auto spoil) {
    Shard shard = random_shard(5);
    spoil(shard);
    return message_of([&] { write_shard(file, shard); });
  };
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  // Index 19 of 8 columns: row 2, column 3.
  EXPECT_EQ(
      message([&](Shard& s) { s.light[1].mean[19] = not_a_number; }),
      file + ": part light_v+10_h010: pixel (3, 2) channel Y = nan; expected a finite value >= 0");
  EXPECT_THAT(message([&](Shard& s) { s.env.variance[0] = infinity; }),
              HasSubstr("part env: pixel (0, 0) channel Y.variance = inf"));
  EXPECT_THAT(message([&](Shard& s) { s.coverage.mean[263] = -0.5f; }),
              HasSubstr("part coverage: pixel (7, 32) channel Y = -0.5"));
  EXPECT_THAT(message([&](Shard& s) { s.coverage.mean.pop_back(); }),
              HasSubstr("part coverage: 263 values and 264 variances; expected 8 x 33 of each"));
  EXPECT_THAT(message([&](Shard& s) { s.env.mean.clear(); }), HasSubstr("part env: 0 values"));
  EXPECT_THAT(message([&](Shard& s) { s.lights.pop_back(); }),
              HasSubstr("3 light pictures for 2 light directions"));
  EXPECT_THAT(message([&](Shard& s) { s.lights[2] = s.lights[1]; }),
              HasSubstr("part light_v+10_h010: twice"));
  EXPECT_THAT(message([&](Shard& s) { s.lights[0].azimuth_deg = 190; }), HasSubstr("h190"));
  EXPECT_THAT(message([&](Shard& s) { s.width_px = 0; }), HasSubstr("0 x 33 pixels"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(StreakDatabase, TruncatedShardIsRefusedByNameAtAnyLength) {
  const TemporaryFolder folder;
  const std::string file = folder / shard_file;
  write_shard(file, random_shard(6));
  const std::string bytes = read_file(file);
  std::mt19937 random(2006);
  for (int i = 0; i < 50; ++i) {
    const std::size_t length = i == 0 ? 0 : i == 1 ? bytes.size() - 1 : random() % bytes.size();
    put_file(file, std::string_view(bytes).substr(0, length));
    const std::string message = message_of([&] { read_shard(file); });
    EXPECT_THAT(message, StartsWith(file + ": ")) << length << " of " << bytes.size() << " bytes";
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  // Behind the headers the message names the part whose pixels are missing.
  put_file(file, std::string_view(bytes).substr(0, bytes.size() - 1));
  EXPECT_THAT(message_of([&] { read_shard(file); }), StartsWith(file + ": part coverage: "));
}

TEST(StreakDatabase, DamagedShardIsRefusedOrReadButNeverCrashes) {
  // Flipped bits inside compressed pixels may still unpack to values; the manifest's hash is what
  // finds those. Here only the outcome counts: a shard, or an error that names the file.
  const TemporaryFolder folder;
  const std::string file = folder / shard_file;
  write_shard(file, random_shard(7));
  const std::string bytes = read_file(file);
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    std::string damaged = bytes;
    // The headers fill the first bytes: half of the damage goes there.
    const std::size_t place = random() % (i % 2 == 0 ? 2000 : bytes.size());
    damaged[place] = static_cast<char>(damaged[place] ^ (1 << random() % 8));
    put_file(file, damaged);
    try {
      read_shard(file);
    } catch (const std::runtime_error& error) {
      ++refused;
      EXPECT_THAT(error.what(), StartsWith(file)) << "bit of byte " << place;
    }
  }
  EXPECT_GT(refused, 50);
}

TEST(StreakDatabase, PartsThatDoNotMakeAShardAreRefused) {
  const TemporaryFolder folder;
  const std::string file = folder / shard_file;
  write_shard(file, random_shard(8));
  const std::vector<ExrPart> good = parse_exr(file, read_file(file));
  const auto message = [&](auto spoil) {
    std::vector<ExrPart> parts = good;
    spoil(parts);
    put_file(file, exr_bytes(parts));
    return message_of([&] { read_shard(file); });
  };
  EXPECT_THAT(message([](auto& parts) { parts.pop_back(); }),
              StartsWith(file + ": part coverage: missing at the end, where env stands"));
  EXPECT_THAT(message([](auto& parts) { parts[1].name = "light_v10_h10"; }),
              HasSubstr("part light_v10_h10: name unknown or out of place"));
  EXPECT_THAT(message([](auto& parts) { parts[1].name = "light_v+95_h010"; }),
              HasSubstr("part light_v+95_h010: expected an elevation of -90 .. 90"));
  EXPECT_THAT(message([](auto& parts) { std::swap(parts[0], parts[3]); }),
              HasSubstr("part env: name unknown or out of place"));
  EXPECT_THAT(
      message([](auto& parts) {
        parts[2].height = 30;
        for (ExrChannel& channel : parts[2].channels) channel.values.resize(240);
      }),
      HasSubstr("part light_v+10_h170: 8 x 30 pixels; expected 8 x 33 like the other parts"));
  EXPECT_THAT(message([](auto& parts) { parts[3].channels.pop_back(); }),
              HasSubstr("part env: other channels; expected Y and Y.variance"));
  EXPECT_THAT(message([](auto& parts) { parts[4].attributes.erase("oscillation"); }),
              HasSubstr("part coverage: no attribute oscillation"));
  EXPECT_THAT(
      message([](auto& parts) { parts[0].attributes["oscillation"] = 4; }),
      HasSubstr("part light_v-90_h170: belongs to d3200_osc04_v-20; expected d3200_osc03_v-20"));
  EXPECT_THAT(message([](auto& parts) {
                parts[3].channels[0].values[9] = std::numeric_limits<float>::quiet_NaN();
              }),
              HasSubstr("part env: pixel (1, 1) channel Y = nan"));
}

TEST(StreakDatabase, ShardUnderAnotherNameIsRefused) {
  const TemporaryFolder folder;
  write_shard(folder / "d3200_osc04_v-20.exr", random_shard(9));
  EXPECT_THAT(
      message_of([&] { read_shard(folder / "d3200_osc04_v-20.exr"); }),
      HasSubstr("belongs to d3200_osc03_v-20; expected d3200_osc04_v-20 as in the file's name"));
  EXPECT_THAT(message_of([&] { read_shard(folder / shard_file); }),
              HasSubstr("cannot read: No such file or directory"));
}

TEST(StreakDatabase, RelativeErrorIsTheRootOfVarianceOverSquares) {
  // Means 3 and 4: squares sum to 25. Variances 0.15 and 0.1: sqrt(0.25 / 25) = 0.1.
  EXPECT_NEAR(estimated_relative_error({.mean = {3, 4}, .variance = {0.15f, 0.1f}}), 0.1, 1e-8);
  EXPECT_EQ(estimated_relative_error({.mean = {0, 0}, .variance = {0, 0}}), 0);
  EXPECT_EQ(estimated_relative_error({}), 0);
}

TEST(StreakDatabase, ManifestIsReadBackExactly) {
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

TEST(StreakDatabase, ManifestOfAnotherVersionOrShapeIsRefusedWithItsKey) {
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

TEST(StreakDatabase, EveryTruncatedManifestIsRefused) {
  const TemporaryFolder folder;
  write_manifest(folder.path(), sample_manifest());
  const std::string text = read_file(folder / "manifest.json");
  for (std::size_t length = 0; length + 2 < text.size(); length += 37) {
    put_file(folder / "manifest.json", text.substr(0, length));
    EXPECT_THAT(message_of([&] { read_manifest(folder.path()); }),
                StartsWith((folder / "manifest.json") + ":"))
        << length << " bytes";
  }
}

TEST(StreakDatabase, ManifestThatCouldNotBeReadBackIsNotWritten) {
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

TEST(StreakDatabase, ShardIsWholeOnlyWithTheBytesOfTheRecord) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "bytes");
  EXPECT_TRUE(shard_is_whole(folder.path(), {.file = "a", .sha256 = sha256("bytes")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = "a", .sha256 = sha256("byte")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = "b", .sha256 = sha256("bytes")}));
  EXPECT_FALSE(shard_is_whole(folder.path(), {.file = ".", .sha256 = sha256("")}));
}

}  // namespace
}  // namespace pluvia
