#include "atlas/streak_atlas.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

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

TEST(StreakAtlas, EveryPixelOfTheDatabaseIsInItsCellAtLevelZero) {
  const TemporaryFolder folder;
  const Sample sample = {.harmonics = 4};
  write_database(folder.path(), sample);
  const StreakAtlas atlas = pack_database(folder.path());
  EXPECT_EQ(atlas.transfer_degree, 1);
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
      for (int i = 0; i < 4; ++i)
        expect_cell(atlas.layers[layer].transfer[0], i,
                    shard.transfer[static_cast<std::size_t>(i)]);
    }
  }
}

TEST(StreakAtlas, WhatIsLeftAfterTheLastOrderComesFromTheSky) {
  const TemporaryFolder folder;
  Manifest manifest = write_database(folder.path(), {.harmonics = 4});
  const StreakAtlas photographs = pack_database(folder.path());
  EXPECT_FALSE(photographs.rest_from_sky) << "a database without orders has all light";
  manifest.parameters = R"({"max_order": 3})";
  write_manifest(folder.path(), manifest);
  const StreakAtlas orders = pack_database(folder.path(), {.rest_from_sky = false});
  const StreakAtlas whole = pack_database(folder.path());
  EXPECT_FALSE(orders.rest_from_sky);
  EXPECT_TRUE(whole.rest_from_sky);
  for (std::size_t i = 0; i < whole.layers.size(); ++i) {
    const AtlasLayer &all = whole.layers[i], &some = orders.layers[i];
    expect_equal(some.env, photographs.layers[i].env);
    expect_equal(some.transfer, photographs.layers[i].transfer);
    expect_equal(all.point, some.point);
    expect_equal(all.env, all.coverage);
    for (std::size_t view = 0; view < whole.views.size(); ++view) {
      const CellRect cell = cell_rect(whole, static_cast<int>(view), 0, 0);
      for (int y = cell.y; y < cell.y + cell.height; ++y) {
        for (int x = 0; x < cell.width; ++x) {
          ASSERT_FLOAT_EQ(all.transfer[0].at(x, y),
                          all.coverage[0].at(x, y) * 0.28209479f);  // 1 / sqrt(4 pi)
          for (int k = 1; k < 4; ++k)
            ASSERT_EQ(all.transfer[0].at(k * cell.width + x, y),
                      some.transfer[0].at(k * cell.width + x, y));
        }
      }
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
    EXPECT_EQ(atlas.views[i].path_bottom_row, Sample().heights[i] - 4.25);
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

TEST(StreakAtlas, CellWidthOfOneTexelHasOneLevel) {
  const TemporaryFolder folder;
  write_database(folder.path(), {.width_px = 1});
  const StreakAtlas atlas = pack_database(folder.path());
  EXPECT_EQ(atlas.levels, 1);
  EXPECT_EQ(atlas.views[1].row_px, 21);
}

// The message of packing a sample after `change`, without the folder's name.
template <typename Change>
std::string packing_message(const Sample& sample, Change change) {
  const TemporaryFolder folder;
  write_database(folder.path(), sample, change);
  const std::string text = message_of([&] { pack_database(folder.path()); });
  EXPECT_THAT(text, StartsWith(folder.path() + "/"));
  return text.substr(folder.path().size() + 1);
}

bool is_last(const Shard& shard) {
  return shard.key.oscillation == 2 && shard.key.view_elevation_deg == 40;
}

void cut_rows(Shard& shard, int height) {
  shard.height_px = height;
  const auto count = static_cast<std::size_t>(shard.width_px) * static_cast<std::size_t>(height);
  const auto cut = [&](StreakImage& image) {
    image.mean.resize(count);
    image.variance.resize(count);
  };
  for (StreakImage& image : shard.light) cut(image);
  cut(shard.env);
  cut(shard.coverage);
}

TEST(StreakAtlas, PicturesThatDoNotFitOneTableAreRefused) {
  EXPECT_EQ(packing_message({.width_px = 24}, [](Shard&) {}),
            "manifest.json: width_px = 24 of shard d3200_osc00_v-20; expected a power of two");
  EXPECT_THAT(packing_message({},
                              [](Shard& shard) {
                                if (is_last(shard)) cut_rows(shard, 8);
                              }),
              StartsWith("manifest.json: shard d3200_osc02_v+40: 8 x 8 pixels, path rows 8.5 .. "
                         "3.75; expected 8 x 16, 8.5 .. 11.75"));
}

TEST(StreakAtlas, ShardsWithOtherPartsThanTheFirstAreRefused) {
  EXPECT_THAT(packing_message({},
                              [](Shard& shard) {
                                if (is_last(shard)) shard.lights[2].azimuth_deg = 50;
                              }),
              StartsWith("shards/d3200_osc02_v+40.exr: 3 light directions; expected the same 3"));
  EXPECT_THAT(packing_message({},
                              [](Shard& shard) {
                                if (is_last(shard)) shard.env = {};
                              }),
              StartsWith("shards/d3200_osc02_v+40.exr: part env is missing; expected it in all"));
  EXPECT_THAT(packing_message({.env = false},
                              [](Shard& shard) {
                                if (is_last(shard)) shard.env = shard.coverage;
                              }),
              StartsWith("shards/d3200_osc02_v+40.exr: part env is there; expected it in all"));
  EXPECT_THAT(packing_message({.harmonics = 4},
                              [](Shard& shard) {
                                if (is_last(shard)) shard.transfer.resize(1);
                              }),
              StartsWith("shards/d3200_osc02_v+40.exr: transfer of degree 0 (-1: none); expected "
                         "1 as in the first"));
  EXPECT_THAT(packing_message({},
                              [](Shard& shard) {
                                shard.lights = {};
                                shard.light = {};
                              }),
              StartsWith("shards/d3200_osc00_v-20.exr: 0 light directions"));
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
              HasSubstr("manifest.json: diameters 3200, 4000 um; expected one diameter"));
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

}  // namespace
}  // namespace pluvia
