#include "atlas/streak_atlas.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A small database: 2 oscillations, 3 views with the odd heights that real ones have, 3 lights.
struct Sample {
  int width_px = 8;
  bool env = true;
  std::vector<int> oscillations = {0, 2};
  std::vector<int> views = {-20, 0, 40};
  std::vector<int> heights = {21, 33, 16};
  std::vector<LightDirection> lights = {{-90, 170}, {10, 10}, {10, 30}};
};

StreakImage random_streak(std::mt19937& random, int count) {
  std::exponential_distribution<float> value(0.5);
  StreakImage image;
  for (int i = 0; i < count; ++i) {
    image.mean.push_back(random() % 3 == 0 ? 0 : value(random));
    image.variance.push_back(1e-6f);
  }
  return image;
}

Shard random_shard(const Sample& sample, int oscillation, std::size_t view) {
  std::mt19937 random(static_cast<unsigned>(oscillation) * 100 + static_cast<unsigned>(view));
  Shard shard = {.key = {.diameter_um = 3200,
                         .oscillation = oscillation,
                         .view_elevation_deg = sample.views[view]},
                 .width_px = sample.width_px,
                 .height_px = sample.heights[view],
                 .lights = sample.lights};
  const int count = shard.width_px * shard.height_px;
  for (std::size_t i = 0; i < shard.lights.size(); ++i) {
    shard.light.push_back(random_streak(random, count));
  }
  if (sample.env) shard.env = random_streak(random, count);
  shard.coverage = random_streak(random, count);
  return shard;
}

ShardRecord write_and_record(const std::string& folder, const Shard& shard) {
  const std::string file = "shards/" + shard_name(shard.key) + ".exr";
  return {.key = shard.key,
          .file = file,
          .sha256 = write_shard(folder + "/" + file, shard),
          .width_px = shard.width_px,
          .height_px = shard.height_px,
          .path_top_row = 8.5,
          .path_bottom_row = shard.height_px - 8.25};
}

// Writes the database; `change` may alter each shard before it is written.
template <typename Change>
Manifest write_database(const std::string& folder, const Sample& sample, Change change) {
  make_folder(folder + "/shards");
  Manifest manifest = {.preset = "test",
                       .parameters = "{}",
                       .seed = 1,
                       .instruction_set = "generic",
                       .mean_radius_m = 1.6e-3,
                       .exposure_s = 1.0 / 60,
                       .fall_speed_m_s = 8.49,
                       .pixel_m = 1.6e-3 / 2.8};
  for (const int oscillation : sample.oscillations) {
    for (std::size_t view = 0; view < sample.views.size(); ++view) {
      Shard shard = random_shard(sample, oscillation, view);
      change(shard);
      manifest.shards.push_back(write_and_record(folder, shard));
    }
  }
  write_manifest(folder, manifest);
  return manifest;
}

Manifest write_database(const std::string& folder, const Sample& sample = {}) {
  return write_database(folder, sample, [](Shard&) {});
}

double sum_of(const Image& picture, const CellRect& cell) {
  double sum = 0;
  for (int y = cell.y; y < cell.y + cell.height; ++y) {
    for (int x = cell.x; x < cell.x + cell.width; ++x) sum += picture.at(x, y);
  }
  return sum;
}

bool contains(const CellRect& cell, int x, int y) {
  return x >= cell.x && x < cell.x + cell.width && y >= cell.y && y < cell.y + cell.height;
}

void expect_equal(const std::vector<Image>& a, const std::vector<Image>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].width, b[i].width);
    EXPECT_EQ(a[i].height, b[i].height);
    EXPECT_EQ(a[i].channels, b[i].channels);
    EXPECT_EQ(a[i].values, b[i].values) << "level " << i;
  }
}

TEST(StreakAtlas, EveryPixelOfTheDatabaseIsInItsCellAtLevelZero) {
  const TemporaryFolder folder;
  const Sample sample;
  write_database(folder.path(), sample);
  const StreakAtlas atlas = pack_database(folder.path());
  ASSERT_EQ(atlas.layers.size(), 2u);
  for (std::size_t layer = 0; layer < 2; ++layer) {
    EXPECT_EQ(atlas.layers[layer].oscillation, sample.oscillations[layer]);
    for (std::size_t view = 0; view < 3; ++view) {
      const Shard shard = random_shard(sample, sample.oscillations[layer], view);
      const auto expect_cell = [&](const Image& picture, int column, const StreakImage& image) {
        const CellRect cell = cell_rect(atlas, static_cast<int>(view), column, 0);
        std::size_t i = 0;
        for (int y = 0; y < cell.height; ++y) {
          for (int x = 0; x < cell.width; ++x)
            ASSERT_EQ(picture.at(cell.x + x, cell.y + y), image.mean[i++]);
        }
        EXPECT_EQ(i, image.mean.size());
      };
      for (int light = 0; light < 3; ++light) {
        expect_cell(atlas.layers[layer].point[0], light,
                    shard.light[static_cast<std::size_t>(light)]);
      }
      expect_cell(atlas.layers[layer].env[0], 0, shard.env);
      expect_cell(atlas.layers[layer].coverage[0], 0, shard.coverage);
    }
  }
}

TEST(StreakAtlas, TablesComeFromTheManifest) {
  const TemporaryFolder folder;
  const Manifest manifest = write_database(folder.path());
  const StreakAtlas atlas = pack_database(folder.path());
  EXPECT_EQ(atlas.cell_width_px, 8);
  EXPECT_EQ(atlas.levels, 4);  // 8, 4, 2, 1 texels
  EXPECT_EQ(atlas.diameter_um, 3200);
  EXPECT_EQ(atlas.mean_radius_m, manifest.mean_radius_m);
  EXPECT_EQ(atlas.exposure_s, manifest.exposure_s);
  EXPECT_EQ(atlas.fall_speed_m_s, manifest.fall_speed_m_s);
  EXPECT_EQ(atlas.pixel_m, manifest.pixel_m);
  EXPECT_EQ(atlas.database_sha256, sha256(read_file(folder / "manifest.json")));
  ASSERT_EQ(atlas.views.size(), 3u);
  // Heights 21, 33, 16 rounded up to multiples of 2^3: 24, 40, 16.
  const int rows[3] = {0, 24, 64};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(atlas.views[i].elevation_deg, Sample().views[i]);
    EXPECT_EQ(atlas.views[i].height_px, Sample().heights[i]);
    EXPECT_EQ(atlas.views[i].row_px, rows[i]);
    EXPECT_EQ(atlas.views[i].path_top_row, 8.5);
    EXPECT_EQ(atlas.views[i].path_bottom_row, Sample().heights[i] - 8.25);
  }
  for (int level = 0; level < 4; ++level) {
    const auto l = static_cast<std::size_t>(level);
    EXPECT_EQ(atlas.layers[0].point[l].width, 24 >> level);
    EXPECT_EQ(atlas.layers[0].point[l].height, 80 >> level);
    EXPECT_EQ(atlas.layers[0].coverage[l].width, 8 >> level);
  }
}

TEST(StreakAtlas, CellsOfOneLevelDoNotOverlapAndLieInThePicture) {
  const TemporaryFolder folder;
  write_database(folder.path());
  const StreakAtlas atlas = pack_database(folder.path());
  for (int level = 0; level < atlas.levels; ++level) {
    Image owners = atlas.layers[0].point[static_cast<std::size_t>(level)];
    for (float& value : owners.values) value = 0;
    for (int view = 0; view < 3; ++view) {
      for (int light = 0; light < 3; ++light) {
        const CellRect cell = cell_rect(atlas, view, light, level);
        const int height = Sample().heights[static_cast<std::size_t>(view)];
        EXPECT_EQ(cell.height, static_cast<int>(std::ceil(height / std::pow(2, level))));
        ASSERT_LE(cell.x + cell.width, owners.width);
        ASSERT_LE(cell.y + cell.height, owners.height);
        for (int y = cell.y; y < cell.y + cell.height; ++y) {
          for (int x = cell.x; x < cell.x + cell.width; ++x) EXPECT_EQ(owners.at(x, y)++, 0);
        }
      }
    }
  }
}

TEST(StreakAtlas, FluxOfACellIsTheSameAtEveryLevel) {
  // A level rounds each texel once: 2^-24 = 6e-8 relative, all terms positive, so 3 levels stay
  // below 2e-7.
  const TemporaryFolder folder;
  write_database(folder.path());
  const StreakAtlas atlas = pack_database(folder.path());
  for (const AtlasLayer& layer : atlas.layers) {
    for (int view = 0; view < 3; ++view) {
      for (int level = 1; level < atlas.levels; ++level) {
        const auto expect_flux = [&](const std::vector<Image>& pictures, int column) {
          const double full = sum_of(pictures[0], cell_rect(atlas, view, column, 0));
          const double mip = sum_of(pictures[static_cast<std::size_t>(level)],
                                    cell_rect(atlas, view, column, level)) *
                             std::pow(4, level);
          EXPECT_GT(full, 0);
          EXPECT_NEAR(mip / full, 1, 2e-7) << "view " << view << " level " << level;
        };
        for (int light = 0; light < 3; ++light) expect_flux(layer.point, light);
        expect_flux(layer.env, 0);
        expect_flux(layer.coverage, 0);
      }
    }
  }
}

TEST(StreakAtlas, ChangedCellChangesNoTexelOfAnotherAtAnyLevel) {
  const TemporaryFolder before;
  const TemporaryFolder after;
  const Sample sample;
  write_database(before.path(), sample);
  write_database(after.path(), sample, [](Shard& shard) {
    if (shard.key.oscillation != 2 || shard.key.view_elevation_deg != 0) return;
    for (float& value : shard.light[1].mean) value += 1000;
  });
  const StreakAtlas a = pack_database(before.path());
  const StreakAtlas b = pack_database(after.path());
  expect_equal(a.layers[0].point, b.layers[0].point);
  expect_equal(a.layers[1].env, b.layers[1].env);
  expect_equal(a.layers[1].coverage, b.layers[1].coverage);
  for (int level = 0; level < a.levels; ++level) {
    const Image& old_picture = a.layers[1].point[static_cast<std::size_t>(level)];
    const Image& new_picture = b.layers[1].point[static_cast<std::size_t>(level)];
    const CellRect cell = cell_rect(a, 1, 1, level);
    for (int y = 0; y < old_picture.height; ++y) {
      for (int x = 0; x < old_picture.width; ++x) {
        EXPECT_EQ(old_picture.at(x, y) != new_picture.at(x, y), contains(cell, x, y))
            << "level " << level << " texel " << x << ", " << y;
      }
    }
  }
}

TEST(StreakAtlas, AtlasIsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  for (const bool env : {true, false}) {
    const std::string database = folder / (env ? "with" : "without");
    write_database(database, {.env = env});
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
    }
  }
}

TEST(StreakAtlas, CellWidthOfOneTexelHasOneLevel) {
  const TemporaryFolder folder;
  write_database(folder.path(), {.width_px = 1});
  const StreakAtlas atlas = pack_database(folder.path());
  EXPECT_EQ(atlas.levels, 1);
  EXPECT_EQ(atlas.views[1].row_px, 21);
}

TEST(StreakAtlas, DatabasesThatDoNotFitOneTableAreRefused) {
  const auto message = [](const Sample& sample, auto change) {
    const TemporaryFolder folder;
    write_database(folder.path(), sample, change);
    const std::string text = message_of([&] { pack_database(folder.path()); });
    EXPECT_THAT(text, StartsWith(folder.path() + "/"));
    return text.substr(folder.path().size() + 1);
  };
  const auto last = [](const Shard& shard) {
    return shard.key.oscillation == 2 && shard.key.view_elevation_deg == 40;
  };
  EXPECT_EQ(message({.width_px = 24}, [](Shard&) {}),
            "manifest.json: width_px = 24 of shard d3200_osc00_v-20; expected a power of two");
  EXPECT_THAT(message({},
                      [&](Shard& shard) {
                        if (last(shard)) shard.lights[2].azimuth_deg = 50;
                      }),
              StartsWith("shards/d3200_osc02_v+40.exr: 3 light directions; expected the same 3"));
  EXPECT_THAT(message({},
                      [&](Shard& shard) {
                        if (last(shard)) shard.env = {};
                      }),
              StartsWith("shards/d3200_osc02_v+40.exr: part env is missing; expected it in all"));
  EXPECT_THAT(message({.env = false},
                      [&](Shard& shard) {
                        if (last(shard)) shard.env = shard.coverage;
                      }),
              StartsWith("shards/d3200_osc02_v+40.exr: part env is there; expected it in all"));
  EXPECT_THAT(message({},
                      [](Shard& shard) {
                        shard.lights = {};
                        shard.light = {};
                      }),
              StartsWith("shards/d3200_osc00_v-20.exr: 0 light directions"));
  EXPECT_THAT(
      message({},
              [&](Shard& shard) {
                if (!last(shard)) return;
                shard.height_px = 8;
                for (StreakImage& image : shard.light) image = shard.coverage;
                for (StreakImage* image : {&shard.light[0], &shard.light[1], &shard.light[2],
                                           &shard.env, &shard.coverage}) {
                  image->mean.resize(64);
                  image->variance.resize(64);
                }
              }),
      StartsWith("manifest.json: shard d3200_osc02_v+40: 8 x 8 pixels, path rows 8.5 .. -0.25; "
                 "expected 8 x 16, 8.5 .. 7.75"));
}

TEST(StreakAtlas, MissingOrChangedShardsAreRefusedByName) {
  const TemporaryFolder folder;
  Manifest manifest = write_database(folder.path());
  const std::string file = folder / "shards/d3200_osc02_v+00.exr";
  const std::string bytes = read_file(file);
  std::filesystem::remove(file);
  EXPECT_EQ(
      message_of([&] { pack_database(folder.path()); }),
      file + ": missing; expected the shard that the manifest lists. run `pluvia generate` again");
  write_file_atomically(file, bytes + "x");
  EXPECT_EQ(message_of([&] { pack_database(folder.path()); }),
            file + ": SHA-256 is not the manifest's; expected " + sha256(bytes) +
                ". run `pluvia generate` again");
  write_file_atomically(file, bytes);
  manifest.shards.erase(manifest.shards.begin() + 4);
  write_manifest(folder.path(), manifest);
  EXPECT_EQ(message_of([&] { pack_database(folder.path()); }),
            (folder / "manifest.json") +
                ": shard d3200_osc02_v+00 is missing; expected each of 2 "
                "oscillations at each of 3 views. run `pluvia generate` again");
  manifest.shards.back().key.diameter_um = 4000;
  write_manifest(folder.path(), manifest);
  EXPECT_THAT(message_of([&] { pack_database(folder.path()); }),
              HasSubstr("manifest.json: diameters 3200 um and 4000 um; expected one diameter"));
  manifest.shards.clear();
  write_manifest(folder.path(), manifest);
  EXPECT_THAT(message_of([&] { pack_database(folder.path()); }),
              HasSubstr("manifest.json: no shards"));
  EXPECT_THAT(message_of([&] { pack_database(folder / "none"); }),
              HasSubstr("none/manifest.json: cannot read: No such file or directory"));
}

TEST(StreakAtlas, RecordThatPointsAtAnotherShardIsRefused) {
  const TemporaryFolder folder;
  Manifest manifest = write_database(folder.path());
  manifest.shards[0].file = manifest.shards[3].file;
  manifest.shards[0].sha256 = manifest.shards[3].sha256;
  write_manifest(folder.path(), manifest);
  EXPECT_THAT(
      message_of([&] { pack_database(folder.path()); }),
      HasSubstr(
          "d3200_osc02_v-20.exr: d3200_osc02_v-20 of 8 x 21 pixels; expected d3200_osc00_v-20"));
}

TEST(StreakAtlas, AtlasFilesThatDoNotBelongTogetherAreRefused) {
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

TEST(StreakAtlas, NotANumberInAnAtlasIsNotWritten) {
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
