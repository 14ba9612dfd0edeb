// A database of noise on disk, small but with odd heights as real ones have, for the tests of the
// atlas.
#pragma once

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/image.h"
#include "atlas/streak_database.h"

namespace pluvia {

struct Sample {
  int width_px = 8;
  bool env = true;
  int harmonics = 0;
  std::vector<int> oscillations = {0, 2};
  std::vector<int> views = {-20, 0, 40};
  std::vector<int> heights = {21, 33, 16};
  std::vector<LightDirection> lights = {{-90, 170}, {10, 10}, {10, 30}};
};

inline StreakImage random_streak(std::mt19937& random, int count) {
  std::exponential_distribution<float> value(0.5);
  StreakImage image;
  for (int i = 0; i < count; ++i) {
    image.mean.push_back(random() % 3 == 0 ? 0 : value(random));
    image.variance.push_back(1e-6f);
  }
  return image;
}

inline Shard random_shard(const Sample& sample, int oscillation, std::size_t view) {
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
  for (int i = 0; i < sample.harmonics; ++i) {
    shard.transfer.push_back(random_streak(random, count));
    for (std::size_t k = 0; k < shard.transfer.back().mean.size(); k += 3)
      shard.transfer.back().mean[k] *= -1;
  }
  return shard;
}

inline ShardRecord write_and_record(const std::string& folder, const Shard& shard) {
  const std::string file = "shards/" + shard_name(shard.key) + ".exr";
  return {.key = shard.key,
          .file = file,
          .sha256 = write_shard(folder + "/" + file, shard),
          .width_px = shard.width_px,
          .height_px = shard.height_px,
          .path_top_row = 8.5,
          .path_bottom_row = shard.height_px - 4.25};
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

inline Manifest write_database(const std::string& folder, const Sample& sample = {}) {
  return write_database(folder, sample, [](Shard&) {});
}

inline void expect_equal(const std::vector<Image>& a, const std::vector<Image>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].width, b[i].width);
    EXPECT_EQ(a[i].height, b[i].height);
    EXPECT_EQ(a[i].values, b[i].values) << "level " << i;
  }
}

}  // namespace pluvia
