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

// A shard with all harmonics of degree 1, which change their sign.
Shard transfer_shard(unsigned seed) {
  Shard shard = random_shard(seed);
  std::mt19937 random(seed + 100);
  for (int k = 0; k < 4; ++k) {
    shard.transfer.push_back(random_streak(random, shard.width_px * shard.height_px));
    for (std::size_t i = 0; i < 50; ++i) shard.transfer.back().mean[3 * i] *= -1;
  }
  return shard;
}

TEST(StreakDatabase, TransferIsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  Shard shard = transfer_shard(2);
  for (const bool env : {true, false}) {
    if (!env) shard.env = {};
    write_shard(folder / shard_file, shard);
    const Shard again = read_shard(folder / shard_file);
    ASSERT_EQ(again.transfer.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k)
      expect_equal(again.transfer[k], shard.transfer[k], "transfer");
    expect_equal(again.env, shard.env, "env");
    EXPECT_EQ(again.lights, shard.lights);
  }
  const auto parts = parse_exr(shard_file, read_file(folder / shard_file));
  ASSERT_EQ(parts.size(), 8u);
  EXPECT_EQ(parts[3].name, "transfer_00");
  EXPECT_EQ(parts[6].name, "transfer_03");
  EXPECT_EQ(parts[7].name, "coverage");
}

TEST(StreakDatabase, TransferThatIsNotWholeIsRefused) {
  const TemporaryFolder folder;
  const std::string file = folder / shard_file;
  const auto unwritable = [&](auto spoil) {
    Shard shard = transfer_shard(3);
    spoil(shard);
    return message_of([&] { write_shard(file, shard); });
  };
  EXPECT_THAT(unwritable([](Shard& s) { s.transfer.pop_back(); }),
              HasSubstr("3 transfer pictures; expected 1, 4, 9, 16 or another square, or none"));
  EXPECT_THAT(unwritable([](Shard& s) { s.transfer[2].mean[9] = std::nanf(""); }),
              HasSubstr("part transfer_02: pixel (1, 1) channel Y = nan; expected a finite value"));
  EXPECT_THAT(unwritable([](Shard& s) { s.transfer[1].variance[0] = -1; }),
              HasSubstr("part transfer_01: pixel (0, 0) channel Y.variance = -1; expected a finite "
                        "value >= 0"));
  write_shard(file, transfer_shard(3));
  const std::vector<ExrPart> good = parse_exr(file, read_file(file));
  const auto unreadable = [&](auto spoil) {
    std::vector<ExrPart> parts = good;
    spoil(parts);
    put_file(file, exr_bytes(parts));
    return message_of([&] { read_shard(file); });
  };
  EXPECT_THAT(unreadable([](auto& parts) { parts.erase(parts.begin() + 7); }),
              HasSubstr("3 transfer pictures; expected 1, 4, 9"));
  EXPECT_THAT(unreadable([](auto& parts) { std::swap(parts[5], parts[6]); }),
              HasSubstr("part transfer_02: out of place; expected transfer_01"));
  EXPECT_THAT(unreadable([](auto& parts) { std::swap(parts[3], parts[4]); }),
              HasSubstr("part transfer_01: out of place; expected transfer_00"));
  EXPECT_THAT(unreadable([](auto& parts) { parts[4].name = "Transfer_00"; }),
              HasSubstr("part transfer_01: out of place; expected transfer_00"));
  EXPECT_THAT(
      unreadable([](auto& parts) { parts[0].name = "transfer_04"; }),
      HasSubstr("part transfer_04: name unknown or out of place; expected light_vSEE_hAAA .., "
                "env, transfer_NN .., coverage"));
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

}  // namespace
}  // namespace pluvia
