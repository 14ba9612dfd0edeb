// pluvia reference as a user meets it.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/run_program.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

constexpr const char* scene_text = R"([camera]
position_m = [0, 0, 1.6]
target_m = [0, 5, 1.6]
width_px = 24
height_px = 40
vertical_fov_deg = 20
[environment]
uniform_cd_m2 = [0.5, 0.6, 0.7]
[[light]]
kind = "point"
position_m = [0.5, 6, 3]
intensity_cd = [60, 50, 40]
[[drop]]
centre_m = [0, 1, 1.7]
oscillation = 3
)";

class ReferenceCommand : public testing::Test {
 protected:
  void SetUp() override { write_scene(scene_text); }
  void write_scene(const std::string& text) const {
    write_file_atomically(folder / "scene.toml", text);
  }
  std::string command(const std::string& out, const std::string& more = "") const {
    return fmt::format("reference {} --start-s 0 --out {} {}", folder / "scene.toml", folder / out,
                       more);
  }
  void expect_complaint(const std::string& arguments, int code, const std::string& text) const {
    const Outcome outcome = run_pluvia(arguments);
    EXPECT_EQ(outcome.code, code) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
    EXPECT_THAT(outcome.err, testing::StartsWith("pluvia")) << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  const TemporaryFolder folder;
};

// Starts the shell's program in its own process, to be killed.
pid_t start(const std::string& arguments) {
  const pid_t child = fork();
  if (child != 0) return child;
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const std::string line = fmt::format("exec {} {}", PLUVIA_PROGRAM, arguments);
  execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
  _exit(127);
}

TEST_F(ReferenceCommand, ARunKilledAgainAndAgainEndsWithTheSameBytes) {
  const auto begin = std::chrono::steady_clock::now();
  const Outcome whole = run_pluvia(command("whole.exr", "--error 0.15"));
  ASSERT_EQ(whole.code, 0) << whole.err;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> moment(0, took.count() / 2);
  int kills = 0;
  for (int i = 0; i < 8; ++i) {
    const pid_t child = start(command("killed.exr", "--error 0.15"));
    std::this_thread::sleep_for(std::chrono::duration<double>(moment(random)));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    kills += WIFSIGNALED(status) ? 1 : 0;
  }
  EXPECT_GT(kills, 0);
  ASSERT_EQ(run_pluvia(command("killed.exr", "--error 0.15")).code, 0);
  EXPECT_EQ(read_file(folder / "killed.exr"), read_file(folder / "whole.exr"));
}

TEST_F(ReferenceCommand, ASmallerErrorGoesOnFromWhatIsThere) {
  ASSERT_EQ(run_pluvia(command("a.exr", "--error 0.3")).code, 0);
  ASSERT_EQ(run_pluvia(command("a.exr", "--error 0.2")).code, 0);
  ASSERT_EQ(run_pluvia(command("b.exr", "--error 0.2 --threads 2")).code, 0);
  EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "b.exr"));
  const Outcome again = run_pluvia(command("a.exr", "--error 0.2"));
  EXPECT_THAT(again.out, HasSubstr("1 drops, "));
  EXPECT_THAT(again.out, HasSubstr(", 0 new"));
}

TEST_F(ReferenceCommand, WrongUseEndsWithTwoAndWrongInputWithOne) {
  for (const std::string flag : {"--error 0", "--error nan", "--budget -1", "--width-px 0",
                                 "--frame -1", "--cone-half-angle-deg 31"})
    expect_complaint(command("a.exr", flag), 2, flag.substr(0, flag.find(' ')));
  expect_complaint("reference " + folder / "scene.toml", 2, "--out is required");
  expect_complaint(command("no/folder/a.exr"), 1, "no/folder/a.exr.sums: cannot write");
  expect_complaint(command("a.exr", "--preset nowhere.toml"), 1, "nowhere.toml: cannot read");
  expect_complaint(command("a.exr", "--budget 0.001"), 1, "a longer --budget");
  expect_complaint(command("a.exr", "--width-px 16384"), 1, "27307 rows; expected at most 16384");
  const std::string lone = R"([[drop]]
centre_m = [0.3, 1, 1.7]
radius_m = 0.0048
)";
  write_scene(std::string(scene_text) + lone);
  expect_complaint(command("a.exr", "--preset " PLUVIA_SOURCE_DIR "/data/presets/physical.toml"), 1,
                   "scene.toml: diameter_m = 0.0096; expected 0 < diameter_m <= 0.009");
  write_scene(scene_text);
  ASSERT_EQ(run_pluvia(command("b.exr", "--error 0.5")).code, 0);
  expect_complaint(command("b.exr", "--seed 2"), 1, "b.exr.sums: sums of another picture");
  write_scene(std::string(scene_text) + "[fog]\nextinction_per_m = 0.01\n");
  expect_complaint(command("c.exr"), 1, "scene.toml: [fog]; expected none");
  write_scene(std::string(scene_text) + "[depth_of_field]\naperture_m = 0.01\n");
  expect_complaint(command("d.exr"), 1, "scene.toml: [depth_of_field]; expected none");
}

TEST_F(ReferenceCommand, DropsHaveTheSetsOfThePresetByNumber) {
  std::string text = read_file(PLUVIA_SOURCE_DIR "/data/presets/gn2006.toml");
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("../oscillations", PLUVIA_SOURCE_DIR "/data/oscillations");
  write_file_atomically(folder / "all.toml", text);
  replace("[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]", "[3]");
  write_file_atomically(folder / "third.toml", text);
  for (const char* preset : {"all", "third"}) {  // the scene's drop is of set 3
    const std::string flags = fmt::format("--error 0.5 --preset {}.toml", folder / preset);
    ASSERT_EQ(run_pluvia(command(fmt::format("{}.exr", preset), flags)).code, 0);
  }
  EXPECT_EQ(read_file(folder / "all.exr"), read_file(folder / "third.exr"));
}

TEST_F(ReferenceCommand, SurfacesStandWhereTheyAreAtTheFramesTime) {
  const std::string car = "[[moving]]\nfile = \"" PLUVIA_SOURCE_DIR "/data/scenes/car.gltf\"\n";
  const auto key = [](double time_s, double y_m) {
    return fmt::format("[[moving.key]]\ntime_s = {}\nposition_m = [0, {}, 0]\n", time_s, y_m);
  };
  const std::string flags = "--error 0.5 --frame 24";  // at 1 s
  for (const double from_m : {300.0, 9.0}) {
    write_scene(scene_text + car + key(0, from_m) + key(1, 9));
    ASSERT_EQ(run_pluvia(command(fmt::format("from{}.exr", from_m), flags)).code, 0);
  }
  EXPECT_EQ(read_file(folder / "from300.exr"), read_file(folder / "from9.exr"));
}

TEST_F(ReferenceCommand, SplashesAreLeftOutAndTheLineSaysSo) {
  write_scene(std::string(scene_text) + "[splashes]\n");
  const Outcome outcome = run_pluvia(command("a.exr", "--error 0.5"));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("splashes are left out"));
}

}  // namespace
}  // namespace pluvia
