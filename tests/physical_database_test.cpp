// Databases of several sizes and bands: generated, read, grown and packed.
#include <cmath>
#include <filesystem>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/streak_atlas.h"
#include "raytrace/generate.h"
#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// One view and three lights, so that a shard takes a few hundredths of a second.
Preset small_preset(const std::string& folder, const std::string& from = "seed = 7",
                    const std::string& to = "seed = 7") {
  Preset preset = read_preset(write_physical(folder, replaced(tiny_physical, from, to)));
  preset.view_elevations_deg = {-80};
  preset.lights = {{10, 170}, {10, 90}, {90, 170}};
  return preset;
}

std::map<std::string, std::string> bytes_of(const std::string& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && name != "cost.json")
      bytes[name] = read_file(entry.path().string());
  }
  return bytes;
}

TEST(PhysicalDatabase, TransferHasAllBands) {
  const TemporaryFolder folder;
  Preset preset = small_preset(folder.path());
  preset.physical->diameters_um = {3000};
  preset.oscillations = {3};
  preset.transfer_degree = 1;
  EXPECT_EQ(generate_database(preset, folder / "db").traced, 1);
  const Manifest manifest = read_manifest(folder / "db");
  EXPECT_THAT(
      manifest.shards.at(0).images,
      testing::ElementsAre("light_v+10_h170", "light_v+10_h090", "light_v+90_h170", "transfer_00",
                           "transfer_01", "transfer_02", "transfer_03", "coverage"));
  const Shard shard = read_shard(folder / "db/" + manifest.shards[0].file);
  const auto count = static_cast<std::size_t>(shard.width_px * shard.height_px);
  for (const StreakImage& image : shard.transfer) EXPECT_EQ(image.mean.size(), 2 * count);
  const auto& means = shard.transfer[2].mean;  // of z: refraction turns blue light farther than red
  EXPECT_NE(std::vector(means.begin(), means.begin() + static_cast<std::ptrdiff_t>(count)),
            std::vector(means.begin() + static_cast<std::ptrdiff_t>(count), means.end()));
}

TEST(PhysicalDatabase, ManifestTellsSizesAndBandsAndShardsHoldThem) {
  const TemporaryFolder folder;
  const Preset preset = small_preset(folder.path());
  EXPECT_EQ(generate_database(preset, folder / "db").traced, 4);
  const Manifest manifest = read_manifest(folder / "db");
  EXPECT_EQ(manifest.bands, bands_of(preset));
  ASSERT_EQ(manifest.sizes.size(), 2u);
  for (const SizeRecord& size : manifest.sizes) {
    EXPECT_EQ(size, size_of(preset, size.diameter_um));
    EXPECT_EQ(size, size_of(manifest, size.diameter_um));
  }
  EXPECT_THROW(size_of(manifest, 1234), std::invalid_argument);
  ASSERT_EQ(manifest.shards.size(), 4u);
  for (const ShardRecord& record : manifest.shards) {
    const StreakFrame frame = shard_frame(preset, record.key);
    EXPECT_EQ(record.height_px, frame.height_px);
    EXPECT_EQ(record.path_bottom_row, frame.path_top_row + frame.path_rows);
    EXPECT_THAT(record.images, testing::ElementsAre("light_v+10_h170", "light_v+10_h090",
                                                    "light_v+90_h170", "coverage"));
    const Shard shard = read_shard(folder / "db/" + record.file);
    const auto count = static_cast<std::size_t>(shard.width_px * shard.height_px);
    EXPECT_THAT(shard.bands, testing::ElementsAre("blue", "red"));
    EXPECT_EQ(shard.lights, preset.lights);
    EXPECT_EQ(shard.light[0].mean.size(), 2 * count);
    EXPECT_EQ(shard.coverage.mean.size(), count);
    EXPECT_TRUE(shard.env.mean.empty());
  }
}

TEST(PhysicalDatabase, EachBandIsWhatItsIndexAloneGives) {
  const TemporaryFolder folder;
  Preset preset = small_preset(folder.path());
  preset.oscillations = {3};
  preset.physical->diameters_um = {3000};
  generate_database(preset, folder / "two");
  const Shard two = read_shard(folder / "two/shards/d3000_osc03_v-80.exr");
  preset.physical->bands.erase(preset.physical->bands.begin());
  generate_database(preset, folder / "one");
  const Shard one = read_shard(folder / "one/shards/d3000_osc03_v-80.exr");
  EXPECT_THAT(one.bands, testing::ElementsAre("red"));
  EXPECT_EQ(one.coverage.mean, two.coverage.mean);
  for (std::size_t k = 0; k < one.light.size(); ++k) {
    const auto& both = two.light[k].mean;
    const std::size_t count = one.light[k].mean.size();
    ASSERT_EQ(both.size(), 2 * count);
    EXPECT_TRUE(std::equal(both.begin() + static_cast<std::ptrdiff_t>(count), both.end(),
                           one.light[k].mean.begin()));
  }
  // Other colours are refracted otherwise: the light behind the drop is another picture.
  const auto& behind = two.light[0].mean;
  EXPECT_FALSE(std::equal(behind.begin(),
                          behind.begin() + static_cast<std::ptrdiff_t>(behind.size() / 2),
                          behind.begin() + static_cast<std::ptrdiff_t>(behind.size() / 2)));
}

TEST(PhysicalDatabase, TheWholeDropIsInThePicture) {
  // Coverage sums to the mean of the projected area over the span; a sphere's, at 0.5 mm, is known,
  // and flattening by (0.5 mm)^2 / (1 mm)^2 of the 1 mm row's 0.011 P2 changes it by 0.3 % at most.
  const TemporaryFolder folder;
  Preset preset = small_preset(folder.path());
  preset.oscillations = {0};
  preset.physical->diameters_um = {500};
  preset.field.base_cells = 16;
  preset.field.space_depth = 3;
  generate_database(preset, folder / "db");
  const Shard shard = read_shard(folder / "db/shards/d0500_osc00_v-80.exr");
  double sum = 0;
  for (const float value : shard.coverage.mean) sum += static_cast<double>(value);
  const double radius_px = 0.25e-3 / size_of(preset, 500).pixel_m;
  // The outline, in cells of a 128th of the map, is straight or cubic: a polygon of some 90 sides
  // would lose 0.1 %. Seams between fine and coarse cells: up to 0.3 % (docs/generator.md).
  EXPECT_NEAR(sum / (3.14159265 * radius_px * radius_px), 1, 0.007);
}

TEST(PhysicalDatabase, GrowsByDiametersAndRefusesOtherLights) {
  const TemporaryFolder folder;
  const Preset preset = small_preset(folder.path());
  Preset one = preset;
  one.physical->diameters_um = {3000};
  EXPECT_EQ(generate_database(one, folder / "grown").traced, 2);
  const GenerateSummary grown = generate_database(preset, folder / "grown");
  EXPECT_EQ(grown.traced, 2);
  EXPECT_EQ(grown.found, 2);
  generate_database(preset, folder / "at_once");
  EXPECT_EQ(bytes_of(folder / "grown"), bytes_of(folder / "at_once"));
  EXPECT_EQ(generate_database(one, folder / "grown").found, 2);
  EXPECT_EQ(bytes_of(folder / "grown"), bytes_of(folder / "at_once")) << "asked for less";
  Preset full = preset;
  full.lights = gn2006_light_directions();
  EXPECT_THAT(message_of([&] { generate_database(full, folder / "grown"); }),
              HasSubstr("manifest.json: lights [\"light_v+10_h170\",\"light_v+10_h090\","));
  EXPECT_EQ(bytes_of(folder / "grown"), bytes_of(folder / "at_once"));
}

TEST(PhysicalDatabase, AShardOfOtherLightsLeftByAKilledRunIsTracedAgain) {
  const TemporaryFolder folder;
  Preset preset = small_preset(folder.path());
  preset.oscillations = {0};
  preset.physical->diameters_um = {500};
  generate_database(preset, folder / "db");
  const auto whole = bytes_of(folder / "db");
  Manifest manifest = read_manifest(folder / "db");
  manifest.shards.clear();
  write_manifest(folder / "db", manifest);
  const std::string file = folder / "db/shards/d0500_osc00_v-80.exr";
  EXPECT_EQ(generate_database(preset, folder / "db").found, 1);
  Shard shard = read_shard(file);
  shard.lights.pop_back();
  shard.light.pop_back();
  write_shard(file, shard);
  write_manifest(folder / "db", manifest);
  EXPECT_EQ(generate_database(preset, folder / "db").traced, 1);
  EXPECT_EQ(bytes_of(folder / "db"), whole);
}

TEST(PhysicalDatabase, PackingTakesOneSizeAndOneBand) {
  const TemporaryFolder folder;
  const Preset preset = small_preset(folder.path());
  generate_database(preset, folder / "db");
  const std::string db = folder / "db";
  EXPECT_THAT(
      message_of([&] { pack_database(db); }),
      HasSubstr("manifest.json: diameters 500, 3000 um; expected one diameter, or the choice"));
  EXPECT_THAT(message_of([&] { pack_database(db, {.diameter_um = 700}); }),
              HasSubstr("diameters 500, 3000 um; expected 700 um among them"));
  EXPECT_THAT(message_of([&] { pack_database(db, {.diameter_um = 500}); }),
              HasSubstr("bands blue, red; expected one, or R, G and B, or the choice of one"));
  EXPECT_THAT(message_of([&] { pack_database(db, {.diameter_um = 500, .band = "Y"}); }),
              HasSubstr("bands blue, red; expected \"Y\" among them"));
  const StreakAtlas atlas = pack_database(db, {.diameter_um = 3000, .band = "red"});
  EXPECT_EQ(atlas.diameter_um, 3000);
  EXPECT_EQ(atlas.mean_radius_m, 1.5e-3);
  EXPECT_EQ(atlas.fall_speed_m_s, size_of(preset, 3000).fall_speed_m_s);
  EXPECT_EQ(atlas.exposure_s, 0.008) << "the time that its pictures cover";
  EXPECT_EQ(atlas.lights, preset.lights);
  const Shard shard = read_shard(db + "/shards/d3000_osc03_v-80.exr");
  const auto count = static_cast<std::size_t>(shard.width_px * shard.height_px);
  for (std::size_t i = 0; i < count; ++i) {
    const auto x = static_cast<int>(i) % shard.width_px, y = static_cast<int>(i) / shard.width_px;
    ASSERT_EQ(atlas.layers[1].point[0].at(x, y), shard.light[0].mean[count + i]) << x << ", " << y;
  }
}

TEST(PhysicalDatabase, PackingRgbMakesLuminance) {
  const TemporaryFolder folder;
  Shard shard = {.key = {.diameter_um = 2000}, .width_px = 4, .height_px = 4};
  shard.bands = {"B", "G", "R"};
  shard.lights = {{10, 170}};
  shard.light.resize(1);
  for (const float value : {3.0f, 2.0f, 1.0f}) {
    shard.light[0].mean.insert(shard.light[0].mean.end(), 16, value);
    shard.light[0].variance.insert(shard.light[0].variance.end(), 16, 0.0f);
  }
  shard.coverage = {.mean = std::vector<float>(16, 1.0f), .variance = std::vector<float>(16, 0.0f)};
  const std::string file = "shards/" + shard_name(shard.key) + ".exr";
  make_folder(folder / "shards");
  Manifest manifest = {.preset = "physical", .parameters = "{}", .exposure_s = 0.01};
  manifest.sizes = {{2000, 1e-3, 6.5, 0.02, 1e-4}};
  manifest.bands = {{"B", 437, 1.34}, {"G", 545, 1.335}, {"R", 634, 1.332}};
  manifest.shards = {{.key = shard.key,
                      .file = file,
                      .sha256 = write_shard(folder / file, shard),
                      .width_px = 4,
                      .height_px = 4}};
  write_manifest(folder.path(), manifest);
  const Shard again = read_shard(folder / file);
  EXPECT_EQ(again.bands, shard.bands);
  EXPECT_EQ(again.light[0].mean, shard.light[0].mean);
  const StreakAtlas atlas = pack_database(folder.path());
  // Rec.709: 0.2126 R + 0.7152 G + 0.0722 B, in float.
  EXPECT_NEAR(static_cast<double>(atlas.layers[0].point[0].at(2, 2)), 0.2126 + 1.4304 + 0.2166,
              1e-6);
  EXPECT_EQ(atlas.layers[0].coverage[0].at(2, 2), 1.0f);
  EXPECT_TRUE(atlas.layers[0].env.empty());
}

TEST(PhysicalDatabase, BandsThatCannotBeStoredAreRefused) {
  const TemporaryFolder folder;
  Shard shard = {.width_px = 1, .height_px = 1};
  shard.coverage = {.mean = {1}, .variance = {0}};
  for (const std::vector<std::string>& bands :
       {std::vector<std::string>{}, {""}, {"R", "R"}, {"R", "G"}, {"a.b"}}) {
    shard.bands = bands;
    EXPECT_THAT(message_of([&] { write_shard(folder / "d3200_osc00_v+00.exr", shard); }),
                HasSubstr("; expected names without a dot, ascending, at least one"));
  }
  shard.bands = {"G", "R"};
  shard.env = {.mean = {1}, .variance = {0}};
  EXPECT_THAT(
      message_of([&] { write_shard(folder / "d3200_osc00_v+00.exr", shard); }),
      HasSubstr("part env: 1 values and 1 variances; expected 1 x 1 of each for each of 2"));
}

TEST(PhysicalDatabase, ManifestsWithWrongSizesAreRefused) {
  const TemporaryFolder folder;
  Manifest manifest = {.preset = "physical", .parameters = "{}", .exposure_s = 0.01};
  manifest.sizes = {{500, 2.5e-4, 2, 0.02, 1e-5}, {3000, 1.5e-3, 8, 0.02, 1e-4}};
  manifest.bands = {{"Y", 589, 1.333}};
  const auto refusal = [&](auto change) {
    Manifest wrong = manifest;
    change(wrong);
    return message_of([&] { write_manifest(folder.path(), wrong); });
  };
  write_manifest(folder.path(), manifest);
  EXPECT_EQ(read_manifest(folder.path()).sizes, manifest.sizes);
  EXPECT_THAT(refusal([](Manifest& m) { std::swap(m.sizes[0], m.sizes[1]); }),
              HasSubstr("manifest.json: sizes[1].diameter_um: 500; expected"));
  EXPECT_THAT(refusal([](Manifest& m) { m.sizes[1].span_s = 0; }), HasSubstr("sizes[1].span_s"));
  EXPECT_THAT(refusal([](Manifest& m) {
                m.bands.push_back({"Y", 600, 1.33});
              }),
              HasSubstr("bands[1].name: \"Y\"; expected ascending names, each once"));
  EXPECT_THAT(refusal([](Manifest& m) {
                m.shards.push_back({.key = {.diameter_um = 700},
                                    .sha256 = std::string(64, 'a'),
                                    .width_px = 1,
                                    .height_px = 1});
              }),
              HasSubstr("shards[0].diameter_um: 700; expected one of the sizes"));
}

}  // namespace
}  // namespace pluvia
