#include "validate/real_factors.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

constexpr const char* head =
    "# made up\nlight_elevation_deg,light_azimuth_deg,osc0,osc1,osc2,osc3,osc4,osc5,osc6,osc7,osc8,"
    "osc9\n";
constexpr const char* row = "10,30,1,2,3,4,5,6,7,8,9,10\n";

std::string refusal_of(const std::string& text) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "factors.csv", text);
  const std::string message = message_of([&] { read_real_factors(folder / "factors.csv"); });
  EXPECT_EQ(message.find(folder / "factors.csv"), 0u) << message;
  return message;
}

TEST(RealFactors, RowsAreReadInTheOrderOfTheFile) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "f.csv",
                        std::string(head) + row + "90,170,.5,1,1,1,1,1,1,1,1,1e-3\n");
  const auto factors = read_real_factors(folder / "f.csv");
  ASSERT_EQ(factors.size(), 20u);
  EXPECT_EQ(factors[3].light, (LightDirection{10, 30}));
  EXPECT_EQ(factors[3].oscillation, 3);
  EXPECT_EQ(factors[3].factor, 4);
  EXPECT_EQ(factors[10].light, (LightDirection{90, 170}));
  EXPECT_EQ(factors[10].factor, 0.5);
  EXPECT_EQ(factors[19].factor, 1e-3);
}

TEST(RealFactors, ShippedTableHasThe190FactorsOfThreeElevations) {
  const auto factors =
      read_real_factors(PLUVIA_SOURCE_DIR "/data/factors/garg_nayar_2006_point_factors.csv");
  EXPECT_EQ(factors.size(), 190u);
  for (const RealFactor& f : factors) {
    EXPECT_THAT(f.light.elevation_deg, testing::AnyOf(10, 50, 90));
  }
}

TEST(RealFactors, BadRowsAreRefusedWithTheirLine) {
  const std::string good = std::string(head) + row;
  EXPECT_THAT(refusal_of(good + "10,50,1,2,3\n"), HasSubstr(":4: 5 columns; expected"));
  EXPECT_THAT(refusal_of(good + "10,50,1,2,x,4,5,6,7,8,9,10\n"), HasSubstr(":4: \"x,4,5"));
  EXPECT_THAT(refusal_of(good + "10,50,1,,3,4,5,6,7,8,9,10\n"), HasSubstr(":4: \",3,4"));
  EXPECT_THAT(refusal_of(good + "10,50,1,2,3,4,5,6,7,8,9,10,\n"), HasSubstr(":4: "));
  for (const std::string bad : {"0", "-1", "nan", "inf"}) {
    EXPECT_THAT(refusal_of(good + "10,50," + bad + ",2,3,4,5,6,7,8,9,10\n"),
                HasSubstr(":4: factor " + bad + "; expected a finite number > 0"));
  }
  for (const std::string bad : {"10.5,50", "nan,50", "91,50", "10,190", "10,-10"}) {
    EXPECT_THAT(refusal_of(good + bad + ",1,2,3,4,5,6,7,8,9,10\n"), HasSubstr(":4: ")) << bad;
  }
  EXPECT_THAT(refusal_of(head), HasSubstr("no rows; expected"));
  const TemporaryFolder folder;
  EXPECT_THAT(message_of([&] { read_real_factors(folder / "none.csv"); }),
              HasSubstr("none.csv: cannot read"));
}

// A database of one-row shards whose light k of oscillation o has maximum 3 o + k + 1, over dark
// pixels.
Manifest write_made_up_database(const std::string& folder, int width_px, float scale) {
  make_folder(folder + "/shards");
  Manifest manifest = {.preset = "test",
                       .parameters = "{}",
                       .seed = 1,
                       .instruction_set = "any",
                       .mean_radius_m = 1.6e-3,
                       .exposure_s = 1.0 / 60,
                       .fall_speed_m_s = 8.49,
                       .pixel_m = 1.4e-4};
  for (int oscillation = 0; oscillation < 2; ++oscillation) {
    Shard shard = {.key = {3200, oscillation, 0},
                   .width_px = width_px,
                   .height_px = 1,
                   .lights = {{10, 10}, {50, 10}, {90, 170}}};
    StreakImage image;
    image.mean.assign(static_cast<std::size_t>(width_px), 0.01f);
    image.variance.assign(static_cast<std::size_t>(width_px), 0);
    shard.coverage = image;
    for (int k = 0; k < 3; ++k) {
      image.mean[static_cast<std::size_t>(k)] = scale * static_cast<float>(3 * oscillation + k + 1);
      shard.light.push_back(image);
      image.mean[static_cast<std::size_t>(k)] = 0;
    }
    ShardRecord record = {.key = shard.key, .file = "shards/" + shard_name(shard.key) + ".exr"};
    record.width_px = width_px;
    record.height_px = 1;
    record.sha256 = write_shard(folder + "/" + record.file, shard);
    manifest.shards.push_back(record);
  }
  return manifest;
}

const std::vector<RealFactor> made_up_factors = {
    {{10, 10}, 0, 1 * 5.0},  {{50, 10}, 0, 2 * 50.0}, {{90, 10}, 0, 3 * 5.0},
    {{10, 10}, 1, 4 * 50.0}, {{50, 10}, 1, 5 * 0.5},  {{90, 170}, 1, 6 * 0.5},
    {{10, 30}, 1, 1},        {{10, 10}, 7, 1}};  // no such light, no such oscillation: left out

TEST(RealFactors, OneConstantIsFittedOnElevations10And90AndJudgedOn50) {
  // log10(ours / theirs) of the fitted four: -log 5, -log 5, -log 50, -log 0.5; their mean is
  // -log 5. After it, oscillation 0 is off by -1 at elevation 50, oscillation 1 by -1, +1 at 10 and
  // 50, +1 at 90.
  const TemporaryFolder folder;
  const Manifest manifest = write_made_up_database(folder.path(), 32, 1);
  const FactorComparison c = compare_factors(folder.path(), manifest, made_up_factors);
  EXPECT_NEAR(c.log10_constant, -std::log10(5.0), 1e-7);
  ASSERT_EQ(c.residuals.size(), 6u);
  const double expected[] = {0, -1, 0, -1, 1, 1};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(c.residuals[k].log10_ratio, expected[k], 1e-7);
  EXPECT_NEAR(factor_rms(c, 0, 50), 1, 1e-7);
  EXPECT_NEAR(factor_rms(c, 0, 10), 0, 1e-7);
  EXPECT_NEAR(factor_rms(c, -1, 10), std::sqrt(0.5), 1e-7);
  EXPECT_NEAR(factor_rms(c, -1, 50), 1, 1e-7);
  EXPECT_THAT(message_of([&] { factor_rms(c, 7, 50); }), HasSubstr("no factor of"));
}

TEST(RealFactors, BrighterUnitChangesTheConstantAndNothingElse) {
  const TemporaryFolder folder, brighter;
  const auto a =
      compare_factors(folder.path(), write_made_up_database(folder.path(), 32, 1), made_up_factors);
  const auto b = compare_factors(brighter.path(), write_made_up_database(brighter.path(), 32, 8),
                                 made_up_factors);
  EXPECT_NEAR(b.log10_constant - a.log10_constant, std::log10(8.0), 1e-7);
  for (std::size_t k = 0; k < a.residuals.size(); ++k) {
    EXPECT_NEAR(a.residuals[k].log10_ratio, b.residuals[k].log10_ratio, 1e-7);
  }
}

TEST(RealFactors, OtherWidthsBlackStreaksAndForeignDatabasesAreRefused) {
  const TemporaryFolder narrow, black, foreign;
  const Manifest narrow_manifest = write_made_up_database(narrow.path(), 16, 1);
  EXPECT_THAT(message_of([&] { compare_factors(narrow.path(), narrow_manifest, made_up_factors); }),
              HasSubstr("d3200_osc00_v+00.exr: 16 px wide; expected 32 px"));
  Manifest manifest = write_made_up_database(black.path(), 32, 1);
  Shard shard = read_shard(black / manifest.shards[0].file);
  std::fill(shard.light[0].mean.begin(), shard.light[0].mean.end(), 0.0f);
  write_shard(black / manifest.shards[0].file, shard);
  EXPECT_THAT(message_of([&] { compare_factors(black.path(), manifest, made_up_factors); }),
              HasSubstr("light of elevation 10 and azimuth 10 of oscillation 0 is black"));
  manifest.shards.clear();
  EXPECT_THAT(message_of([&] { compare_factors(foreign.path(), manifest, made_up_factors); }),
              HasSubstr(foreign.path() + ": no shard of view elevation 0"));
}

}  // namespace
}  // namespace pluvia
