// `pluvia compose` as a user runs it: its files, their bytes, and what it refuses.
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <nlohmann/json.hpp>

#include "atlas/depth_picture.h"
#include "atlas/exr_parts.h"
#include "atlas/gray_png.h"
#include "atlas/image_io.h"
#include "realtime/compose_command.h"
#include "realtime/particle_files.h"
#include "tests/realtime_fixture.h"
#include "tests/run_program.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* scene_text = R"(
[camera]
position_m = [0, 0, 1.6]
target_m = [0, 5, 1.7]
width_px = 64
height_px = 36
white_cd_m2 = 2
[environment]
uniform_cd_m2 = [1, 1.2, 1.5]
[rain]
drops_per_m3 = 20
box_min_m = [-3, 1, 0]
box_max_m = [3, 8, 4]
seed = 77
)";

constexpr float sky = std::numeric_limits<float>::infinity();

// Also what is not finite.
void write_depth(const std::string& file, const Image& depth_m) {
  const ExrPart part = {
      .width = depth_m.width, .height = depth_m.height, .channels = {{"Z", depth_m.values}}};
  write_file_plainly(file, exr_bytes({part}));
}

// A scene, its atlas, a picture with a grey ramp and depths, nearer on the left.
struct Inputs {
  TemporaryFolder folder = {};
  Image depth_m = make_image(64, 36);

  Inputs() {
    write_file_plainly(folder / "scene.toml", scene_text);
    StreakAtlas atlas = quarter_atlas();
    atlas.diameter_um = 3200;
    write_atlas(folder / "atlas", atlas);
    Image picture = make_image(64, 36, 3);
    for (int y = 0; y < 36; ++y) {
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = static_cast<float>(x + c) / 66;
        depth_m.at(x, y) = x < 32 ? 4.0f : sky;
      }
    }
    write_png(folder / "picture.png", picture);
    write_depth(folder / "depth.exr", depth_m);
  }
  ComposeFlags flags(const std::string& out) const {
    ComposeFlags flags;
    flags.scene = folder / "scene.toml";
    flags.image = folder / "picture.png";
    flags.depth = folder / "depth.exr";
    flags.atlas = folder / "atlas";
    flags.out = folder / out;
    return flags;
  }
};

void compose(const ComposeFlags& flags) {
  compose_frames(flags, [](const std::string&, double) {});
}

std::map<std::string, std::string> contents_of(const std::string& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      contents[fs::relative(entry.path(), folder).string()] = read_file(entry.path().string());
  }
  return contents;
}

TEST(Compose, WritesLayersThatAddUpAndSaysHow) {
  PLUVIA_NEEDS_OPENGL();
  const Inputs inputs;
  compose(inputs.flags("out"));
  const std::string out = inputs.folder / "out";
  const Image color = read_image(out + "/composite/0000.exr");
  const Image background = read_image(out + "/background/0000.exr");
  const Image rain = read_image(out + "/rain/0000.exr");
  const Image coverage = read_image(out + "/coverage/0000.exr");
  const Image mask = read_image(out + "/mask/0000.png");
  int covered = 0;
  for (std::size_t i = 0; i < color.values.size(); ++i) {
    const double left = 1 - static_cast<double>(coverage.values[i / 3]);
    ASSERT_EQ(color.values[i], static_cast<float>(left * static_cast<double>(background.values[i]) +
                                                  static_cast<double>(rain.values[i])));
    ASSERT_EQ(mask.values[i / 3], coverage.values[i / 3] >= 0.01f ? 1 : 0);
    covered += coverage.values[i / 3] > 0 ? 1 : 0;
  }
  EXPECT_GT(covered, 100);
  // A PNG's white is the camera's; half a step of sRGB, 1/510, is at most 1/510 of its steepest.
  for (int x = 0; x < 64; ++x)
    EXPECT_NEAR(background.at(x, 0, 1), 2 * (x + 1) / 66.0, 2 * 2.4 / 1.055 / 510);
  const auto json = nlohmann::json::parse(read_file(out + "/compose.json"));
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("seed"), 77);
  EXPECT_EQ(json.at("scene_sha256"), sha256(scene_text));
  EXPECT_EQ(json.at("frames").size(), 1u);
  EXPECT_GT(json.at("frames")[0].at("drops_listed"), 0);
}

TEST(Compose, GivesTheSameBytesForTheSameSeedWhateverTheThreads) {
  PLUVIA_NEEDS_OPENGL();
  const Inputs inputs;
  ComposeFlags flags = inputs.flags("one");
  flags.frames = 2;
  compose(flags);
  flags.out = inputs.folder / "two";
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    compose(flags);
  }
  const auto one = contents_of(inputs.folder / "one");
  EXPECT_GE(one.size(), 15u);  // six of each frame, drops.csv, camera0.xml, compose.json
  EXPECT_EQ(one, contents_of(flags.out));
  write_file_plainly(flags.scene, std::regex_replace(scene_text, std::regex("77"), "78"));
  flags.out = inputs.folder / "other";
  compose(flags);
  EXPECT_NE(one.at("composite/0000.exr"), contents_of(flags.out).at("composite/0000.exr"));
}

TEST(Compose, TakesPicturesAndDepthsFrameByFrame) {
  PLUVIA_NEEDS_OPENGL();
  const Inputs inputs;
  make_folder(inputs.folder / "clip");
  make_folder(inputs.folder / "depths");
  for (int k = 0; k < 3; ++k) {
    Image picture = make_image(64, 36);
    std::fill(picture.values.begin(), picture.values.end(), static_cast<float>(k + 1));
    write_exr(fmt::format("{}/clip/{}.exr", inputs.folder.path(), k), picture);
    Image depth_m = make_image(64, 36);
    std::fill(depth_m.values.begin(), depth_m.values.end(), k == 1 ? 0.05f : sky);
    write_depth(fmt::format("{}/depths/{}.exr", inputs.folder.path(), k), depth_m);
  }
  ComposeFlags flags = inputs.flags("out");
  flags.image = "";
  flags.video = inputs.folder / "clip";
  flags.depth = inputs.folder / "depths/*.exr";
  compose(flags);
  for (int k = 0; k < 3; ++k) {
    const auto layer = [&](const char* name) {
      return read_image(fmt::format("{}/{}/{:04}.exr", flags.out, name, k));
    };
    // Floats are cd/m^2; the mean of four alike is rounded three times.
    EXPECT_NEAR(layer("background").at(5, 5, 2), k + 1, 1e-6);
    const Image coverage = layer("coverage");
    const float most = *std::max_element(coverage.values.begin(), coverage.values.end());
    EXPECT_EQ(most > 0, k != 1) << "frame " << k;  // nothing before a wall at 5 cm
  }
  flags.out = inputs.folder / "more";
  fs::remove(inputs.folder / "depths/2.exr");
  EXPECT_THAT(message_of([&] { compose(flags); }), HasSubstr("2 depths; expected one for all"));
  EXPECT_FALSE(fs::exists(flags.out));
  flags.frames = 2;
  compose(flags);
  fs::remove(inputs.folder / "clip/1.exr");
  fs::remove(inputs.folder / "clip/2.exr");
  flags.frames.reset();
  flags.out = inputs.folder / "fewer";
  EXPECT_THAT(message_of([&] { compose(flags); }), HasSubstr("2 depths; expected one for all"));
  EXPECT_FALSE(fs::exists(flags.out));
}

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(line);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

FrameDrops made_up_drops() {
  FrameDrops frame = {.frame = 3, .time_s = 1.0 / 3};
  for (int i = 0; i < 3; ++i) {
    ListedDrop listed = {.id = 7 * i, .end_s = 0.01 / 3};
    listed.drop.centre_m = {0.1 + i, -1.0 / 3, 2e-9};
    listed.drop.velocity_m_s = {0.1, 0, -8.49 / 3};
    listed.drop.r0_m = 1.6e-3 / 7;
    listed.drop.oscillation = i;
    listed.start_px = {1.0 / 7, 30};
    listed.end_px = {2.0 / 7, -3.5};
    listed.start_width_px = 0.3;
    listed.end_width_px = 1.0 / 9;
    listed.start_camera_m = {1.0 / 11, 0.2, 3};
    listed.end_camera_m = {1.0 / 13, -0.2, 3.1};
    listed.shown_share = 1.0 / 99;
    frame.drops.push_back(listed);
  }
  return frame;
}

TEST(DropFiles, ReadBackAsTheListedDrops) {
  Scene scene;
  scene.rain.seed = 4711;
  const FrameDrops frame = made_up_drops();
  const auto lines = split(drops_csv_head(scene) + drops_csv_rows(frame), '\n');
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_THAT(lines[0], HasSubstr("seed 4711"));
  const auto names = split(lines[1], ',');
  for (std::size_t i = 0; i < 3; ++i) {
    const auto cells = split(lines[i + 2], ',');
    ASSERT_EQ(cells.size(), names.size());
    const auto value = [&](const char* name) {
      const auto at = std::find(names.begin(), names.end(), name);
      return std::stod(cells.at(static_cast<std::size_t>(at - names.begin())));
    };
    const ListedDrop& drop = frame.drops[i];
    EXPECT_EQ(value("frame"), 3);
    EXPECT_EQ(value("time_s"), frame.time_s);
    EXPECT_EQ(value("id"), drop.id);
    EXPECT_EQ(value("y_m"), drop.drop.centre_m.y());
    EXPECT_EQ(value("z_m"), drop.drop.centre_m.z());
    EXPECT_EQ(value("radius_m"), drop.drop.r0_m);
    EXPECT_EQ(value("velocity_z_m_s"), drop.drop.velocity_m_s.z());
    EXPECT_EQ(value("oscillation"), drop.drop.oscillation);
    EXPECT_EQ(value("fall_s"), drop.end_s);
    EXPECT_EQ(value("start_x_px"), drop.start_px.x());
    EXPECT_EQ(value("end_y_px"), drop.end_px.y());
    EXPECT_EQ(value("end_width_px"), drop.end_width_px);
    EXPECT_EQ(value("start_forward_m"), drop.start_camera_m.z());
    EXPECT_EQ(value("end_up_m"), drop.end_camera_m.y());
    EXPECT_EQ(value("distance_m"), (drop.start_camera_m + drop.end_camera_m).norm() / 2);
    EXPECT_EQ(value("shown_share"), drop.shown_share);
  }
}

// As the reader of rain-rendering does: integers by int(), places by cutting the brackets and
// splitting at semicolons, y of the picture turned over, z of places with the other sign.
TEST(DropFiles, ReadBackFromXmlAsTheAugmentationReadsThem) {
  Scene scene;
  scene.camera.height_px = 36;
  const FrameDrops frame = made_up_drops();
  const std::string text =
      particles_xml_head() + particles_xml_frame(scene, frame) + particles_xml_tail();
  EXPECT_THAT(text, HasSubstr("<frame id=\"3\" t=\"17\" d=\"333\" rs=\"3\">"));
  const std::regex element("<drop ([^/]*)/>"), attribute("(\\w+)=\"([^\"]*)\"");
  std::size_t i = 0;
  for (std::sregex_iterator d(text.begin(), text.end(), element), end; d != end; ++d, ++i) {
    std::map<std::string, std::string> given;
    const std::string inside = (*d)[1];
    for (std::sregex_iterator a(inside.begin(), inside.end(), attribute); a != end; ++a)
      given[(*a)[1]] = (*a)[2];
    const auto number = [&](const char* name, std::size_t place) {
      const std::string& value = given.at(name);
      EXPECT_EQ(value.front(), '(');
      EXPECT_EQ(value.back(), ')');
      return std::stod(split(value.substr(1, value.size() - 2), ';').at(place));
    };
    const ListedDrop& drop = frame.drops.at(i);
    EXPECT_EQ(std::stoi(given.at("pid")), drop.id);
    EXPECT_EQ(number("wp1", 0), drop.start_camera_m.x());
    EXPECT_EQ(number("wp2", 1), drop.end_camera_m.y());
    EXPECT_EQ(-number("wp2", 2), drop.end_camera_m.z());
    EXPECT_EQ(number("ip1", 0), drop.start_px.x());
    // 36 - y and back: one rounding of 36 each.
    EXPECT_NEAR(36 - number("ip1", 1), drop.start_px.y(), 2 * 0x1p-53 * 64);
    EXPECT_NEAR(36 - number("ip2", 1), drop.end_px.y(), 2 * 0x1p-53 * 64);
    EXPECT_EQ(std::stod(given.at("iw1")), drop.start_width_px);
    EXPECT_EQ(std::stod(given.at("iw2")), drop.end_width_px);
    EXPECT_EQ(std::stod(given.at("wd1")), 2 * drop.drop.r0_m);
    EXPECT_EQ(given.at("wd2"), given.at("wd1"));
  }
  EXPECT_EQ(i, 3u);
}

TEST(DepthPicture, IsInMetresWithAnInfiniteSky) {
  const TemporaryFolder folder;
  Image depth_m = make_image(2, 1);
  depth_m.values = {1.5f, sky};
  write_depth(folder / "depth.exr", depth_m);
  EXPECT_EQ(read_depth(folder / "depth.exr", 0).values, depth_m.values);
  write_file_plainly(folder / "depth.png", gray_png_bytes({2, 1, {384, 65535}}));
  EXPECT_EQ(read_depth(folder / "depth.png", 1 / 256.0).values, depth_m.values);
  std::filesystem::rename(folder / "depth.png", folder / "depth2.PNG");
  EXPECT_EQ(read_depth(folder / "depth2.PNG", 1 / 256.0).values, depth_m.values);
}

TEST(DepthPicture, IsRefusedWhereItIsNoDepth) {
  const TemporaryFolder folder;
  for (const float bad : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) {
    Image depth_m = make_image(3, 2);
    std::fill(depth_m.values.begin(), depth_m.values.end(), 1.0f);
    depth_m.at(2, 1) = bad;
    write_depth(folder / "bad.exr", depth_m);
    EXPECT_THAT(message_of([&] { read_depth(folder / "bad.exr", 0); }),
                HasSubstr(fmt::format("bad.exr: pixel (2, 1) has depth {} m; expected", bad)));
  }
  write_file_plainly(folder / "zero.png", gray_png_bytes({2, 1, {384, 0}}));
  EXPECT_THAT(message_of([&] { read_depth(folder / "zero.png", 1e-3); }),
              HasSubstr("zero.png: pixel (1, 0) has depth 0 m"));
  EXPECT_THAT(message_of([&] { read_depth(folder / "zero.png", 0); }),
              HasSubstr("--depth-scale-m"));
  EXPECT_THAT(message_of([&] { read_depth(folder / "none.exr", 0); }), HasSubstr("no such file"));
  EXPECT_THAT(message_of([&] { read_depth(folder / "bad.exr", 1e-3); }),
              HasSubstr("bad.exr: has metres of its own; expected no --depth-scale-m"));
}

TEST(ComposeProgram, RefusesInOneLineAndLeavesNothing) {
  PLUVIA_NEEDS_OPENGL();
  const Inputs inputs;
  write_exr(inputs.folder / "small.exr", make_image(32, 18, 3));
  Image depth_m = inputs.depth_m;
  depth_m.at(3, 4) = -2;
  write_depth(inputs.folder / "negative.exr", depth_m);
  const auto refused = [&](const std::string& image, const std::string& depth,
                           const std::string& more, int code, const std::string& part) {
    const std::string in = inputs.folder.path() + "/";
    const Outcome run = run_pluvia(
        fmt::format("compose {0}scene.toml {1} --depth {0}{2} --atlas {0}atlas --out {0}out {3}",
                    in, image.empty() ? "" : "--image " + in + image, depth, more));
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_THAT(run.err, HasSubstr(part));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(in + "out"));
    EXPECT_FALSE(fs::exists(in + "out.pluvia-tmp"));
  };
  refused("", "depth.exr", "", 2, "--image, --video: expected one of them");
  refused("picture.png", "depth.exr", "--video v.mp4", 2, "expected one of them");
  refused("picture.png", "depth.exr", "--far-streaks 4", 2, "--far-streaks");
  refused("picture.png", "depth.exr", "--mask-coverage nan", 2, "--mask-coverage");
  refused("picture.png", "depth.exr", "--masks m", 2, "--masks: the look has none");
  refused("none.png", "depth.exr", "", 1, "none.png: cannot read: ");
  refused("picture.png", "none.exr", "", 1, "none.exr: cannot read: no such file");
  refused("small.exr", "depth.exr", "", 1,
          "small.exr: 32 x 18 pixels; expected 64 x 36 like the camera of ");
  refused("picture.png", "small.exr", "", 1, "small.exr: pixel (0, 0) has depth 0 m");
  refused("picture.png", "negative.exr", "", 1, "negative.exr: pixel (3, 4) has depth -2 m");
  refused("picture.png", "picture.png", "--depth-scale-m 1", 1, "expected 16 bits of grey");
  make_folder(inputs.folder / "two");
  write_depth(inputs.folder / "two/a.exr", inputs.depth_m);
  write_depth(inputs.folder / "two/b.exr", inputs.depth_m);
  refused("", "depth.exr", "--frames 3 --video " + inputs.folder.path() + "/picture.png", 1,
          "picture.png: 1 frames; expected 3, as --frames says");
  refused("two", "depth.exr", "", 1, "two: 2 pictures; expected one, or --video");
  refused("picture.png", "two", "", 1, "two: 2 depths; expected one for all frames");
  make_folder(inputs.folder / "there");
  const Outcome there = run_pluvia(fmt::format(
      "compose {0}/scene.toml --image {0}/picture.png --depth {0}/depth.exr --atlas {0}/atlas "
      "--out {0}/there",
      inputs.folder.path()));
  EXPECT_EQ(there.code, 1);
  EXPECT_THAT(there.err, HasSubstr("there: is there already"));
}

}  // namespace
}  // namespace pluvia
