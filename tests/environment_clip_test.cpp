#include "atlas/environment_clip.h"

#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

// Of one colour, which tells its number.
Image map_of(int k, int height = 8) {
  Image map = make_image(2 * height, height, 3);
  for (std::size_t i = 0; i < map.values.size(); ++i)
    map.values[i] = 0.1f * static_cast<float>(k + 1) + 0.01f * static_cast<float>(i % 3);
  return map;
}

std::string pattern_of(const TemporaryFolder& folder, int count, const char* kind = "exr") {
  for (int k = 0; k < count; ++k) {
    const std::string file = folder / fmt::format("sky_{:02}.{}", k, kind);
    std::string(kind) == "exr" ? write_exr(file, map_of(k)) : write_png(file, map_of(k));
  }
  return folder / ("sky_*." + std::string(kind));
}

TEST(EnvironmentClip, EachPictureIsTheMapOfItsNumber) {
  const TemporaryFolder folder;
  EnvironmentClip clip(pattern_of(folder, 4));
  for (const int k : {0, 1, 1, 3, 0}) {
    EXPECT_EQ(clip.at(k).values, map_of(k).values);
    EXPECT_EQ(clip.shown(), k);
    EXPECT_FALSE(clip.held());
  }
}

TEST(EnvironmentClip, AfterItsEndTheLastIsHeld) {
  const TemporaryFolder folder;
  EnvironmentClip clip(pattern_of(folder, 3));
  EXPECT_EQ(clip.at(1000000).values, map_of(2).values);
  EXPECT_TRUE(clip.held());
  EXPECT_EQ(clip.shown(), 2);
  EXPECT_EQ(clip.at(2).values, map_of(2).values);
  EXPECT_FALSE(clip.held());
}

TEST(EnvironmentClip, ASinglePictureIsAClipOfOne) {
  const TemporaryFolder folder;
  pattern_of(folder, 1);
  EnvironmentClip clip(folder / "sky_00.exr");
  EXPECT_EQ(clip.at(0).values, map_of(0).values);
  EXPECT_EQ(clip.at(9).values, map_of(0).values);
  EXPECT_TRUE(clip.held());
  EXPECT_EQ(clip.at(0).values, map_of(0).values);
  EXPECT_FALSE(clip.held());
}

TEST(EnvironmentClip, WholeNumbersAreDecodedToLight) {
  const TemporaryFolder folder;
  EnvironmentClip clip(pattern_of(folder, 2, "png"));
  // 8 bits of sRGB: half a step is at most 0.5 / 255 x 2.3, the slope at white.
  for (const int k : {0, 1}) {
    const Image& map = clip.at(k);
    for (std::size_t i = 0; i < map.values.size(); ++i)
      EXPECT_NEAR(map.values[i], map_of(k).values[i], 0.0046);
  }
}

TEST(EnvironmentClip, AVideoGivesTheSameMapWhereverItIsAskedFrom) {
  const TemporaryFolder folder;
  // Frames that cannot be told from their neighbours but by their own light, in groups of pictures
  // of which most lean on others.
  for (int k = 0; k < 20; ++k) {
    Image map = make_image(64, 32, 3);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c)
          map.at(x, y, c) = 0.02f * static_cast<float>((x + 3 * k) % 32 + c);
      }
    }
    write_png(folder / fmt::format("{:02}.png", k), map);
  }
  const std::string video = folder / "sky.mp4";
  const std::string command = "ffmpeg -loglevel error -framerate 24 -i " + (folder / "%02d.png") +
                              " -c:v libx264 -g 12 -bf 3 -pix_fmt yuv420p " + video;
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg";
  ASSERT_EQ(std::system(command.c_str()), 0);
  // OpenImageIO 2.4 gives the last two of such a video as the one before them.
  EnvironmentClip in_order(video);
  std::vector<Image> maps;
  for (int k = 0; k < 20; ++k) maps.push_back(in_order.at(k));
  EXPECT_NE(maps[3].values, maps[4].values);
  for (const int k : {17, 5, 12}) {
    EnvironmentClip alone(video);
    EXPECT_EQ(alone.at(k).values, maps[static_cast<std::size_t>(k)].values) << k;
    EXPECT_EQ(in_order.at(k).values, maps[static_cast<std::size_t>(k)].values) << k;
    // What it should be: 8 bits, half the resolution of colour, and a coder's losses.
    double off = 0;
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x)
        off +=
            std::abs(static_cast<double>(alone.at(k).at(x, y, 1)) - 0.02 * ((x + 3 * k) % 32 + 1));
    }
    EXPECT_LT(off / (64 * 32), 0.03) << k;
  }
  EXPECT_EQ(in_order.at(20).values, maps[19].values);
  EXPECT_TRUE(in_order.held());
}

TEST(EnvironmentClip, WhatIsNoLatLongMapIsRefusedByName) {
  const TemporaryFolder folder;
  EXPECT_THAT(message_of([&] { EnvironmentClip(folder / "sky_*.exr"); }),
              HasSubstr("sky_*.exr: no file of that name"));
  EXPECT_THAT(message_of([&] { EnvironmentClip(folder / "none.mp4").at(0); }),
              HasSubstr("none.mp4: cannot read"));
  const std::string pattern = pattern_of(folder, 2);
  write_exr(folder / "sky_01.exr", map_of(1, 16));
  EXPECT_THAT(message_of([&] {
                EnvironmentClip clip(pattern);
                clip.at(0);
                clip.at(1);
              }),
              HasSubstr("sky_01.exr: 32 pixels wide; expected 16 like the others of"));
  write_exr(folder / "sky_01.exr", make_image(16, 16, 3));
  EXPECT_THAT(message_of([&] { EnvironmentClip(pattern).at(1); }),
              HasSubstr("sky_01.exr: 16 x 16 pixels, 3 channels; expected width = 2 * height"));
  write_exr(folder / "sky_01.exr", make_image(16, 8));
  EXPECT_THAT(message_of([&] { EnvironmentClip(pattern).at(1); }),
              HasSubstr("sky_01.exr: 16 x 8 pixels, 1 channels; expected"));
}

TEST(EnvironmentClip, ABlackMapIsNight) {
  const TemporaryFolder folder;
  write_exr(folder / "sky_00.exr", make_image(16, 8, 3));
  EXPECT_EQ(EnvironmentClip(folder / "sky_*.exr").at(0).values, make_image(16, 8, 3).values);
}

}  // namespace
}  // namespace pluvia
