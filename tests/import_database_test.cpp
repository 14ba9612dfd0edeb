#include "raytrace/import_database.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atlas_lookup.h"
#include "atlas/export_gn2006.h"
#include "atlas/gray_png.h"
#include "atlas/streak_atlas.h"
#include "tests/preset_files.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int view = 80;  // the shortest pictures: 216 rows
constexpr int height_px = 216;

// A layout of one view, written here without the exporter: ten oscillations of 75 pictures. Only a
// few rows are not black, as behind a real drop.
struct Layout {
  ViewFactors factors = {.view_elevation_deg = view, .point = {}};
  std::map<std::string, GrayPicture> pictures = {};
};

GrayPicture random_picture(std::mt19937& random) {
  GrayPicture picture = {.width = 32, .height = height_px};
  picture.values.assign(32 * height_px, 0);
  for (int i = 0; i < 1000; ++i) {
    picture.values[random() % picture.values.size()] = static_cast<std::uint16_t>(random());
  }
  picture.values[random() % picture.values.size()] = 65535;
  return picture;
}

Layout random_layout() {
  std::mt19937 random(2006);
  std::uniform_real_distribution<double> factor(0.002, 0.9);
  const auto lights = gn2006_light_directions();
  Layout layout;
  layout.factors.point.resize(lights.size());
  const GrayPicture shared = random_picture(random);
  for (int o = 0; o < gn2006_oscillations; ++o) {
    const auto place = static_cast<std::size_t>(o);
    layout.factors.env[place] = gn2006_told_factor(factor(random));
    layout.pictures[gn2006_env_picture(32, view, o)] = random_picture(random);
    for (std::size_t k = 0; k < lights.size(); ++k) {
      layout.factors.point[k][place] = gn2006_told_factor(factor(random));
      layout.pictures[gn2006_point_picture(32, view, lights[k], o)] =
          k % 20 == 0 ? random_picture(random) : shared;
    }
  }
  return layout;
}

void write_layout(const std::string& root, const Layout& layout) {
  const auto put = [&](const std::string& name, const std::string& bytes) {
    make_folder(fs::path(root + "/" + name).parent_path().string());
    write_file_plainly(root + "/" + name, bytes);
  };
  put(gn2006_env_factor_file(), gn2006_env_factor_text({layout.factors}));
  put(gn2006_point_factor_file(view), gn2006_point_factor_text(layout.factors));
  for (const auto& [name, picture] : layout.pictures) put(name, gray_png_bytes(picture));
}

class Import : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = std::make_unique<TemporaryFolder>();
    write_layout(*shared / "layout", layout);
  }
  static void TearDownTestSuite() { shared.reset(); }

  // The message of an import of the layout with one file replaced; empty text: removed.
  std::string refusal(const std::string& name, const std::string& bytes) const {
    const std::string file = *shared / ("layout/" + name);
    const std::string before = read_file(file);
    if (bytes.empty())
      fs::remove(file);
    else
      write_file_plainly(file, bytes);
    const std::string message = message_of(
        [&] { import_gn2006(*shared / "layout", folder / "db", preset, StreakLevel::transit); });
    write_file_plainly(file, before);
    EXPECT_FALSE(fs::exists(folder / "db"));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }

  static std::unique_ptr<TemporaryFolder> shared;
  static inline const Layout layout = random_layout();
  const TemporaryFolder folder;
  const Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/gn2006.toml");
};

std::unique_ptr<TemporaryFolder> Import::shared;

double maximum(const StreakImage& image) {
  return *std::max_element(image.mean.begin(), image.mean.end());
}

TEST_F(Import, ValuesAreThoseOfThePicturesAndVarianceIsTheRoundings) {
  const std::string root = *shared / "layout";
  EXPECT_EQ(import_gn2006(root, folder / "db", preset, StreakLevel::transit), 10);
  EXPECT_EQ(import_gn2006(root, folder / "exposed", preset, StreakLevel::exposure), 10);
  const std::string name = "/shards/d3200_osc06_v+80.exr";
  const Shard transit = read_shard(folder / "db" + name);
  const Shard exposure = read_shard(folder / "exposed" + name);
  const double covered = maximum(transit.coverage);
  EXPECT_EQ(covered, maximum(exposure.coverage));
  for (const std::size_t k : {std::size_t{0}, std::size_t{33}, std::size_t{73}}) {
    const auto& values =
        layout.pictures.at(gn2006_point_picture(32, view, transit.lights[k], 6)).values;
    const double step = layout.factors.point[k][6] / 65535;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double brightness = values[i] * step;  // kept to the last bit of a float: 2^-24
      ASSERT_NEAR(exposure.light[k].mean[i], brightness, 6e-8 * brightness);
      ASSERT_NEAR(transit.light[k].mean[i], brightness * covered, 6e-8 * brightness * covered);
    }
    EXPECT_FLOAT_EQ(exposure.light[k].variance[5], static_cast<float>(step * step / 12));
  }
  EXPECT_EQ(maximum({.mean = exposure.coverage.variance}), 0);
}

TEST_F(Import, ManifestSaysWhatIsKnownAndTheAtlasCanBePacked) {
  import_gn2006(*shared / "layout", folder / "db", preset, StreakLevel::transit);
  const Manifest manifest = read_manifest(folder / "db");
  EXPECT_EQ(manifest.preset, "gn2006-import");
  EXPECT_THAT(manifest.parameters, HasSubstr("\"level\":\"transit\""));
  EXPECT_THAT(manifest.parameters, HasSubstr("\"variance\":\"of the rounding to 16 bits alone\""));
  EXPECT_EQ(manifest.seed, 0u);
  ASSERT_EQ(manifest.shards.size(), 10u);
  EXPECT_EQ(manifest.shards[3].images.size(), 76u);
  EXPECT_EQ(manifest.shards[3].path_top_row, 18);
  const StreakAtlas atlas = pack_database(folder / "db");
  EXPECT_EQ(atlas.layers.size(), 10u);
  EXPECT_EQ(atlas.lights.size(), 74u);
  EXPECT_EQ(atlas.views.front().height_px, height_px);
}

TEST_F(Import, WhatWasImportedIsExportedToTheSameBytes) {
  import_gn2006(*shared / "layout", folder / "imported", preset, StreakLevel::transit);
  // The exporter wants five views: four of other pictures, small and quickly written.
  const Sample others = {.width_px = 32,
                         .oscillations = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
                         .views = {0, 20, 40, 60},
                         .heights = {32, 24, 16, 8},
                         .lights = gn2006_light_directions()};
  Manifest manifest = write_database(folder / "db", others);
  for (const ShardRecord& record : read_manifest(folder / "imported").shards) {
    fs::copy(folder / "imported/" + record.file, folder / "db/" + record.file);
    manifest.shards.push_back(record);
  }
  std::sort(manifest.shards.begin(), manifest.shards.end(),
            [](const ShardRecord& a, const ShardRecord& b) { return comes_before(a.key, b.key); });
  write_manifest(folder / "db", manifest);
  export_gn2006(folder / "db", folder / "out");
  for (const auto& [name, picture] : layout.pictures) {
    const std::string theirs = read_file(*shared / ("layout/" + name));
    ASSERT_EQ(read_file(folder / ("out/" + name)), theirs) << name;
  }
  EXPECT_EQ(read_file(folder / ("out/" + gn2006_point_factor_file(view))),
            gn2006_point_factor_text(layout.factors));
  EXPECT_THAT(read_file(folder / ("out/" + gn2006_env_factor_file())),
              testing::EndsWith(gn2006_env_factor_text({layout.factors})));
}

TEST_F(Import, DamagedLayoutsAreRefusedWithFileAndPlace) {
  const std::string env = gn2006_env_factor_file(), point = gn2006_point_factor_file(view);
  EXPECT_THAT(refusal(env, ""), HasSubstr(env + ": cannot read: No such file"));
  EXPECT_THAT(refusal(env, "cv80\n1 2\n"), HasSubstr(env + ":2:4: end of the line after 2"));
  EXPECT_THAT(refusal(point, ""), HasSubstr(point + ": cannot read: No such file"));
  EXPECT_THAT(refusal(point, "cv80\nv-90\nh170 x"), HasSubstr(point + ":3:6: \"x\"; expected"));
  const std::string picture = gn2006_point_picture(32, view, {10, 30}, 0);
  EXPECT_THAT(refusal(picture, ""), HasSubstr(picture + ": cannot read: No such file"));
  EXPECT_THAT(refusal(picture, "x"), HasSubstr(picture + ": cannot be read: it is not a PNG"));
  const GrayPicture small = {.width = 16, .height = 2, .values = std::vector<std::uint16_t>(32)};
  EXPECT_THAT(refusal(picture, gray_png_bytes(small)),
              HasSubstr(picture + ": 16 x 2 pixels; expected 32 x 216 as in the preset"));
  ViewFactors black = layout.factors;
  black.env[0] = 0;
  EXPECT_THAT(refusal(env, gn2006_env_factor_text({black})),
              HasSubstr("cv80_osc0.png: not black, with a factor of 0; expected a factor > 0"));
}

}  // namespace
}  // namespace pluvia
