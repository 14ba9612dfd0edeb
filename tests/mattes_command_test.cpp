// `pluvia mattes` as a user runs it, and the clips that it reads.
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "atlas/clip_files.h"
#include "atlas/image_io.h"
#include "realtime/video.h"
#include "tests/rain_clip.h"
#include "tests/run_program.h"

namespace pluvia {
namespace {

void write_clip(const std::string& folder, const RainClip& clip) {
  make_folder(folder);
  for (std::size_t k = 0; k < clip.frames.size(); ++k)
    write_png(fmt::format("{}/{:02}.png", folder, k), clip.frames[k]);
}

TEST(ClipFiles, AreReadAsLinearLightFromFoldersAndPatterns) {
  const TemporaryFolder folder;
  const RainClip clip = rain_clip({.width = 32, .height = 32, .frames = 4});
  write_clip(folder / "clip", clip);
  write_exr(folder / "clip.exr", clip.frames[0]);
  const auto by_folder = read_clip(folder / "clip", 20);
  ASSERT_EQ(by_folder.size(), 4u);
  // Half a step of sRGB, 1/510, is at most 1/510 of the curve's steepest, 2.4 / 1.055 at white.
  for (std::size_t i = 0; i < clip.frames[2].values.size(); ++i)
    ASSERT_NEAR(by_folder[2].values[i], clip.frames[2].values[i], 2.4 / 1.055 / 510);
  EXPECT_EQ(read_clip(folder / "clip/*.png", 3)[2].values, by_folder[2].values);
  EXPECT_EQ(read_clip(folder / "cl*.exr", 3)[0].values, clip.frames[0].values);
}

TEST(ClipFiles, AreReadFromVideos) {
  if (!ffmpeg_is_present()) GTEST_SKIP() << "no ffmpeg on the PATH";
  const TemporaryFolder folder;
  const Image shown = textured_background(64, 48, false);
  VideoWriter video(folder / "clip.mp4", 64, 48, 24);
  for (int k = 0; k < 5; ++k) video.add(shown, 1);
  video.finish();
  const auto frames = read_clip(folder / "clip.mp4", 4);
  ASSERT_EQ(frames.size(), 4u);
  // H.264 with one colour for 2 x 2 pixels: far from exact, yet no other transfer curve: taken as
  // linear, the light would be 0.2 and more too bright.
  double sum = 0;
  for (std::size_t i = 0; i < shown.values.size(); ++i)
    sum += frames[3].values[i] - shown.values[i];
  EXPECT_NEAR(sum / static_cast<double>(shown.values.size()), 0, 0.02);
}

TEST(MattesProgram, WritesBackgroundMattesStrokesAndNumbers) {
  const TemporaryFolder folder;
  write_clip(folder / "clip", rain_clip({.width = 48, .height = 48, .frames = 6}));
  const Outcome run =
      run_pluvia(fmt::format("mattes {0}/clip --out {0}/m --iterations 2", folder.path()));
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(read_file(folder / "m/mattes.json"));
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("frames"), 6);
  EXPECT_EQ(json.at("rain_colours").size(), 6u);
  EXPECT_EQ(json.at("rain_colours")[0].size(), 3u);
  EXPECT_EQ(read_image(folder / "m/background.exr").width, 48);
  EXPECT_EQ(read_image(folder / "m/mattes/0005.png").height, 48);
  for (const auto& stroke : json.at("strokes")) {
    const Image picture =
        read_image(folder / ("m/" + stroke.at("file").get<std::string>() + ".exr"));
    EXPECT_GE(picture.height, stroke.at("length_px").get<double>());
  }
}

TEST(MattesProgram, RefusesInOneLineAndLeavesNothing) {
  const TemporaryFolder folder;
  write_clip(folder / "clip", rain_clip({.width = 32, .height = 32, .frames = 4}));
  write_file_plainly(folder / "bad.mp4", "no video");
  write_file_plainly(folder / "clip/zz.txt", "");
  const auto run = [&](const std::string& arguments) {
    return run_pluvia("mattes " + arguments + " --out " + folder / "out");
  };
  const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << arguments;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  };
  refused(folder / "none.mp4", 1, "none.mp4: cannot read: ");
  refused(folder / "bad.mp4", 1, "expected a video or a picture");
  refused(folder / "clip", 1, "files of 2 kinds, .png and .txt; expected one");
  refused(folder / "clip/00.png", 1, "1 frames; expected a video of at least 3");
  refused(folder / "'clip/*.gif'", 1, "no file of that name; expected pictures");
  refused(folder / "'clip/*.png' --frames 2", 2, "--frames");
  refused(folder / "'clip/*.png' --mu nan", 2, "--mu");
}

}  // namespace
}  // namespace pluvia
