// The program as a user meets it: exit codes, one line of complaint, nothing left behind.

#include <algorithm>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "tests/preset_files.h"
#include "tests/realtime_fixture.h"
#include "tests/run_program.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void expect_complaint(const std::string& arguments, int code, const std::string& text) {
  const Outcome outcome = run_pluvia(arguments);
  EXPECT_EQ(outcome.code, code) << arguments;
  EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
  EXPECT_THAT(outcome.err, testing::StartsWith("pluvia")) << arguments;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(outcome.out, "") << arguments;
}

// A small database of two views and its atlas, made by the program itself once for all tests.
class Program : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = std::make_unique<TemporaryFolder>();
    write_preset(shared->path(), replaced(tiny_preset, "[80]", "[0, 80]"));
    made = {run_pluvia(fmt::format("generate {0}/preset.toml --out {0}/db", shared->path())),
            run_pluvia(fmt::format("pack {0}/db --out {0}/atlas", shared->path()))};
  }
  static void TearDownTestSuite() { shared.reset(); }

  // A scene of rain in the folder with lines of [camera], then other tables.
  std::string write_scene(const std::string& environment, const std::string& camera = "") const {
    const std::string file = folder / "scene.toml";
    write_file_atomically(
        file, fmt::format("[camera]\nposition_m = [0, 0, 1.6]\ntarget_m = [0, 5, 1.6]\n"
                          "width_px = 64\nheight_px = 36\n{}\n{}\n[rain]\ndrops_per_m3 = 50\n"
                          "box_min_m = [-2, 1, 0]\nbox_max_m = [2, 4, 4]\n",
                          camera, environment));
    return file;
  }
  std::string render_flags(const std::string& scene) const {
    return fmt::format("render {} --atlas {}/atlas --out {}/frames", scene, shared->path(),
                       folder.path());
  }
  void expect_nothing_rendered() const { EXPECT_FALSE(fs::exists(folder / "frames")); }

  static std::unique_ptr<TemporaryFolder> shared;
  static std::vector<Outcome> made;
  const TemporaryFolder folder;
};

std::unique_ptr<TemporaryFolder> Program::shared;
std::vector<Outcome> Program::made;

TEST_F(Program, GenerateAndPackSayOneLineOfWhatTheyMade) {
  ASSERT_EQ(made[0].code, 0) << made[0].err;
  EXPECT_THAT(made[0].out, HasSubstr("/db: 4 shards traced in "));
  EXPECT_THAT(made[0].out, HasSubstr("0 found finished\n"));
  EXPECT_EQ(std::count(made[0].out.begin(), made[0].out.end(), '\n'), 1) << made[0].out;
  ASSERT_EQ(made[1].code, 0) << made[1].err;
  EXPECT_EQ(made[1].out, fmt::format("{0}/atlas: packed from {0}/db\n", shared->path()));
  EXPECT_EQ(made[1].err, "");
}

TEST_F(Program, HelpOfEverySubcommandHasAnExampleAndGoesToTheOutput) {
  const std::string overview = run_pluvia("--help").out;
  for (const std::string command :
       {"generate", "merge", "export", "import", "pack", "masks", "render", "reference", "view",
        "validate", "compare-reports", "sweep"}) {
    const Outcome outcome = run_pluvia(command + " --help");
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_THAT(outcome.out, HasSubstr("example: pluvia " + command));
    EXPECT_EQ(outcome.err, "") << command;
    EXPECT_THAT(overview, HasSubstr(command));
  }
}

TEST_F(Program, WrongUseEndsWithTwo) {
  const std::string preset = *shared / "preset.toml";
  const std::string out = folder / "db";
  expect_complaint("", 2, "subcommand is required");
  expect_complaint("gnerate", 2, "unknown subcommand \"gnerate\"");
  expect_complaint("generate " + preset, 2, "--out is required");
  const std::string generate = fmt::format("generate {} --out {} ", preset, out);
  expect_complaint(generate + "--colour", 2, "--colour");
  for (const std::string value :
       {"--views 81", "--cone-half-angle-deg nan", "--cone-half-angle-deg 31",
        "--cone-half-angle-deg 0.01", "--threads 2.5", "--error 0", "--error nan", "--isa sse9"}) {
    expect_complaint(generate + value, 2, value.substr(0, value.find(' ')));
  }
  expect_complaint(generate + "--oscillations 0,4", 2,
                   "--oscillations: 4; expected one of the preset's 0, 3");
  for (const std::string value : {"0/3", "4/3", "3", "1/", "/1", "1/2/3", "-1/2", "1/1e3", "x"}) {
    expect_complaint(generate + "--shard " + value, 2,
                     "--shard: " + value + "; expected i/n with 1 <= i <= n");
  }
  expect_complaint("export db --out " + out, 2, "--layout is required");
  expect_complaint("export db --layout other --out " + out, 2, "--layout");
  expect_complaint("export db --layout gn2006 --level both --out " + out, 2, "--level");
  expect_complaint("export db --layout gn2006 --normalise no --out " + out, 2, "--normalise");
  expect_complaint("import l --level 1 --out " + out, 2, "--level");
  expect_complaint("merge --out " + out, 2, "databases is required");
  const std::string render = fmt::format("render s.toml --atlas a --out {} ", out);
  for (const std::string value : {"--frames 0", "--start-s nan", "--look cube",
                                  "--background-share 1", "--streak-cd-m2 -1"}) {
    expect_complaint(render + value, 2, value.substr(0, value.find(' ')));
  }
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Program, GenerateForASceneTracesWhatItAsksForAndRendersIt) {
  // The tiny preset has the views 0 and 80; a level camera with drops from 1 m on needs both as
  // neighbours, but few lights of a lamp far ahead.
  const std::string scene = write_scene(
      "[environment]\nuniform_cd_m2 = [1, 1, 1]\n[[light]]\nposition_m = [0, 200, 20]\n"
      "intensity_cd = [1, 1, 1]");
  const std::string generate =
      fmt::format("generate {}/preset.toml --out {}", shared->path(), folder / "db");
  const Outcome outcome = run_pluvia(generate + " --for " + scene);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("views        kept     +0, +80\n"));
  EXPECT_THAT(outcome.out, HasSubstr("             left out light_v-90_h170, "));
  EXPECT_THAT(outcome.out, HasSubstr("4 of 4 shards, "));
  EXPECT_THAT(outcome.out, HasSubstr("/db: 4 shards traced in "));
  const std::string manifest = read_file(folder / "db/manifest.json");
  EXPECT_THAT(manifest, HasSubstr("\"lights\": ["));
  // The subset is no part of a full database, nor the other way round.
  EXPECT_THAT(run_pluvia(generate).err, HasSubstr("manifest.json: lights [\"light_v"));
  EXPECT_THAT(run_pluvia(fmt::format("generate {0}/preset.toml --out {0}/db --for {1}",
                                     shared->path(), scene))
                  .err,
              HasSubstr("manifest.json: lights absent; expected [\"light_v"));
  EXPECT_EQ(read_file(folder / "db/manifest.json"), manifest);
  ASSERT_EQ(run_pluvia(fmt::format("pack {0}/db --out {0}/atlas", folder.path())).code, 0);
  PLUVIA_NEEDS_OPENGL();
  const Outcome rendered = run_pluvia(
      fmt::format("render {0} --atlas {1}/atlas --out {1}/frames", scene, folder.path()));
  EXPECT_EQ(rendered.code, 0) << rendered.err;
}

TEST_F(Program, GenerateRefusesSizesViewsAndScenesThatThePresetDoesNotServe) {
  const std::string preset = *shared / "preset.toml";
  const std::string generate = fmt::format("generate {} --out {} ", preset, folder / "none");
  expect_complaint(generate + "--views -20", 2, "--views: -20; expected 0 .. 80 for gn2006");
  expect_complaint(generate + "--diameters-mm 4", 2,
                   "--diameters-mm: 4; expected among the preset's 3.2");
  expect_complaint(generate + "--diameters-mm nan", 2, "--diameters-mm");
  expect_complaint(generate + "--for " + (folder / "none.toml"), 1, "none.toml: cannot read");
  expect_complaint(generate + "--for " + write_scene("", "exposure_s = 2"), 1,
                   "camera.exposure_s = 2; expected 0 < exposure_s <= 1 s");
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST_F(Program, BadInputOfGenerateEndsWithOneAndNamesFileAndPlace) {
  const std::string out = " --out " + (folder / "db");
  const auto generate = [&](const std::string& text, const std::string& sets = tiny_sets) {
    return "generate " + write_preset(folder.path(), text, sets) + out;
  };
  expect_complaint("generate " + (folder / "none.toml") + out, 1,
                   "none.toml: cannot read: No such file or directory");
  expect_complaint(generate(replaced(tiny_preset, "seed", "sed")), 1,
                   "preset.toml:3:1: unknown key");
  expect_complaint(generate(replaced(tiny_preset, "8.49", "nan")), 1, "preset.toml:13:1: ");
  expect_complaint(generate(replaced(tiny_preset, "[drop]", "[drop")), 1, "preset.toml:5:");
  expect_complaint(
      generate(tiny_preset, replaced(replaced(tiny_sets, "0.11", "0.4"), "0.1\n", "0.4\n")), 1,
      "sets.toml:8:1: set 3: the drop's surface comes as near as");
  EXPECT_FALSE(fs::exists(folder / "db"));
}

TEST_F(Program, FitOfOutlinesSaysWhatItFoundAndRefusesWhatIsNoDrop) {
  const std::string out = " --out " + (folder / "fit.json");
  const std::string example = std::string(PLUVIA_SOURCE_DIR) + "/data/outlines/synthetic.csv";
  const Outcome outcome = run_pluvia("fit outlines " + example + out);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("A20 0.11"));
  EXPECT_THAT(read_file(folder / "fit.json"), HasSubstr("\"name\": \"phi_drop_deg\""));
  EXPECT_THAT(run_pluvia("fit outlines --help").out, HasSubstr("example: pluvia fit outlines"));
  for (const std::string mode : {"--modes 34", "--modes 20,20", "--equilibrium-mm nan"}) {
    expect_complaint("fit outlines " + example + out + " " + mode, 2, mode.substr(0, 7));
  }
  expect_complaint("fit outlines " + example, 2, "--out is required");
  std::string table = "# source: none\nt_s,theta_deg,r_mm\n";
  for (int k = 0; k < 60; ++k) {
    table += fmt::format("{},{},{}\n", 1e-4 * k, 37 * k % 360, 0.1 + 0.07 * (k * 29 % 60));
  }
  write_file_atomically(folder / "noise.csv", table);
  fs::remove(folder / "fit.json");
  expect_complaint(fmt::format("fit outlines {}/noise.csv{}", folder.path(), out), 1,
                   "noise.csv: the radii scatter by ");
  EXPECT_THAT(read_file(folder / "fit.json"), testing::Not(HasSubstr("\"value\"")));
  write_file_atomically(folder / "bad.csv", "# source: s\nt_s,theta_deg,r_mm\n0,0,x\n");
  expect_complaint(fmt::format("fit outlines {}/bad.csv{}", folder.path(), out), 1,
                   "bad.csv:3:5: r_mm = \"x\"");
}

TEST_F(Program, FoldersThatCannotBeWrittenEndWithOneAndStayAsTheyWere) {
  write_file_atomically(folder / "plain", "x");
  for (const std::string& out : {folder / "plain", folder / "plain/below"}) {
    const std::string flag = " --out " + out;
    expect_complaint("generate " + (*shared / "preset.toml") + flag, 1, "Not a directory");
    expect_complaint("pack " + (*shared / "db") + flag, 1, "Not a directory");
    expect_complaint(
        fmt::format("validate --database {0}/db --atlas {0}/atlas{1}", shared->path(), flag), 1,
        "Not a directory");
  }
  EXPECT_EQ(read_file(folder / "plain"), "x");
}

TEST_F(Program, PackRefusesDatabasesThatAreNotWhole) {
  const std::string out = " --out " + (folder / "atlas");
  expect_complaint("pack " + (folder / "none") + out, 1, "none/manifest.json: cannot read");
  fs::copy(*shared / "db", folder / "db", fs::copy_options::recursive);
  const std::string shard = folder / "db/shards/d3200_osc03_v+80.exr";
  const std::string bytes = read_file(shard);
  write_file_atomically(shard, bytes.substr(0, bytes.size() / 2));
  expect_complaint("pack " + (folder / "db") + out, 1, "d3200_osc03_v+80.exr: ");
  fs::remove(shard);
  expect_complaint("pack " + (folder / "db") + out, 1, "d3200_osc03_v+80.exr: ");
  EXPECT_FALSE(fs::exists(folder / "atlas"));
}

TEST_F(Program, DatabasesThatCannotBeExportedImportedOrMergedEndWithOne) {
  const std::string out = " --out " + (folder / "out");
  expect_complaint("export " + (*shared / "db") + " --layout gn2006" + out, 1,
                   "db/manifest.json: 46 of the layout's 50 shards missing: d3200_osc00_v+20");
  expect_complaint("import " + (*shared / "db") + out, 1, "normalized_env_max.txt: cannot read");
  expect_complaint(fmt::format("merge {0}/db {0}/none{1}", shared->path(), out), 1,
                   "none/manifest.json: cannot read");
  const std::string other = fmt::format(
      "generate {}/preset.toml --views 80 --oscillations 0 --cone-half-angle-deg 4 --out {}",
      shared->path(), folder / "other");
  ASSERT_EQ(run_pluvia(other).code, 0);
  expect_complaint(fmt::format("merge {}/db {}{}", shared->path(), folder / "other", out), 1,
                   "other/manifest.json: cone_half_angle_deg 4.0; expected 5.0 as in ");
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(Program, OtherPresetIntoADatabaseIsRefusedByName) {
  expect_complaint(
      fmt::format("generate {0}/preset.toml --cone-half-angle-deg 4 --out {0}/db", shared->path()),
      1, "manifest.json: cone_half_angle_deg 5.0; expected 4.0");
}

TEST_F(Program, RenderWritesFramesAndKeepsWhatElseLiesThere) {
  PLUVIA_NEEDS_OPENGL();
  const std::string scene = write_scene("[environment]\nuniform_cd_m2 = [1, 1, 1]");
  make_folder(folder / "frames");
  write_file_atomically(folder / "frames/notes.txt", "mine");
  const Outcome outcome = run_pluvia(render_flags(scene));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(read_file(folder / "frames/notes.txt"), "mine");
  EXPECT_THAT(outcome.out, HasSubstr("/frames: 1 frames, surfaces "));
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << outcome.out;
  EXPECT_EQ(outcome.err, fmt::format("100 % {}/frames/frame_0000\n", folder.path()));
  const Image frame = read_image(folder / "frames/frame_0000.exr");
  EXPECT_EQ(frame.width, 64);
  EXPECT_EQ(frame.height, 36);
  EXPECT_TRUE(fs::exists(folder / "frames/frame_0000.png"));
  EXPECT_THAT(read_file(folder / "frames/costs.json"), HasSubstr("\"pass\": \"rain\""));
}

TEST_F(Program, FramesOfALongerRunDoNotStayBesideThoseOfAShorterOne) {
  PLUVIA_NEEDS_OPENGL();
  const std::string scene = write_scene("[environment]\nuniform_cd_m2 = [1, 1, 1]");
  make_folder(folder / "frames");
  write_file_atomically(folder / "frames/frame_best.png", "mine");
  ASSERT_EQ(run_pluvia(render_flags(scene) + " --frames 3").code, 0);
  EXPECT_TRUE(fs::exists(folder / "frames/frame_0002.exr"));
  ASSERT_EQ(run_pluvia(render_flags(scene)).code, 0);
  EXPECT_TRUE(fs::exists(folder / "frames/frame_0000.exr"));
  for (const char* name :
       {"frame_0001.exr", "frame_0001.png", "frame_0002.exr", "frame_0002.png", "rain.mp4"})
    EXPECT_FALSE(fs::exists(fs::path(folder / "frames") / name)) << name;
  EXPECT_EQ(read_file(folder / "frames/frame_best.png"), "mine");
}

TEST_F(Program, RenderRefusesBadScenes) {
  expect_complaint(render_flags(folder / "none.toml"), 1, "none.toml: cannot read");
  expect_complaint(render_flags(write_scene("[environmnt]")), 1, "scene.toml:7:");
  expect_complaint(render_flags(write_scene("", "exposure_s = nan")), 1, "scene.toml:6:1: ");
  expect_complaint(render_flags(write_scene("[geometry]\nfile = \"none.gltf\"")), 1, "none.gltf");
  expect_nothing_rendered();
}

TEST_F(Program, RenderRefusesExposuresTooShortForStreaks) {
  PLUVIA_NEEDS_OPENGL();
  const std::string uniform = "[environment]\nuniform_cd_m2 = [1, 1, 1]";
  expect_complaint(render_flags(write_scene(uniform, "exposure_s = 1e-5")), 1,
                   "camera.exposure_s = 1e-05 s; expected 0.00039 s or more, in which");
  expect_nothing_rendered();
}

TEST_F(Program, RenderTellsItsPlanWithoutDrawing) {
  PLUVIA_NEEDS_OPENGL();
  const std::string scene = write_scene("[environment]\nuniform_cd_m2 = [1, 1, 1]\n[fog]");
  const std::string flags = fmt::format("render {} --atlas {}/atlas ", scene, shared->path());
  const Outcome outcome = run_pluvia(flags + "--plan");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* pass : {"surfaces ", "fog ", "rain ", "composite ", "rain.frag", "atlas: sums"})
    EXPECT_THAT(outcome.out, HasSubstr(pass));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("shadows ")));
  expect_nothing_rendered();
  expect_complaint(flags, 2, "--out: is required without --plan");
}

TEST_F(Program, RenderSaysWhichOpenGlItFoundWhereItIsTooOld) {
  PLUVIA_NEEDS_OPENGL();
  // Mesa's drivers then claim to be no better; another driver has no such wish.
  setenv("MESA_GL_VERSION_OVERRIDE", "4.1", 1);
  const Outcome outcome = run_pluvia(render_flags(write_scene("")));
  unsetenv("MESA_GL_VERSION_OVERRIDE");
  if (outcome.code == 0) GTEST_SKIP() << "this driver cannot be made to offer OpenGL 4.1";
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(
      outcome.err,
      testing::MatchesRegex("pluvia render: OpenGL: version 4\\.1 .*; expected OpenGL 4.5 core\n"));
  EXPECT_EQ(outcome.out, "");
  expect_nothing_rendered();
}

TEST_F(Program, RenderRefusesDirtyEnvironmentMaps) {
  PLUVIA_NEEDS_OPENGL();
  const auto render_under = [&](const std::string& map) {
    return render_flags(write_scene(fmt::format("[environment]\nmap = \"{}\"", map)));
  };
  const std::string raw = PLUVIA_SOURCE_DIR "/data/environments/raw_park.exr";
  expect_complaint(render_under(raw), 1, "raw_park.exr: pixel (");
  expect_complaint(render_under(folder / "none.exr"), 1, "none.exr: cannot read");
  write_file_atomically(folder / "empty.exr", "");
  expect_complaint(render_under(folder / "empty.exr"), 1, "empty.exr: cannot be read: it is empty");
  const std::string bytes = read_file(raw);
  write_file_atomically(folder / "cut.exr", bytes.substr(0, bytes.size() / 2));
  expect_complaint(render_under(folder / "cut.exr"), 1, "cut.exr: cannot be read");
  write_exr(folder / "black.exr", make_image(8, 4, 3));
  expect_complaint(render_under(folder / "black.exr"), 1, "black.exr: all pixels are 0; expected");
  write_exr(folder / "square.exr", make_image(4, 4, 3));
  expect_complaint(render_under(folder / "square.exr"), 1, "square.exr: 4 x 4 pixels");
  expect_nothing_rendered();
}

TEST_F(Program, RenderRefusesForeignAtlases) {
  const std::string scene = write_scene("");
  const auto render_with = [&](const std::string& atlas) {
    return fmt::format("render {} --atlas {} --out {}/frames", scene, atlas, folder.path());
  };
  expect_complaint(render_with(folder / "none"), 1, "none/atlas.json: cannot read");
  fs::copy(*shared / "atlas", folder / "atlas", fs::copy_options::recursive);
  const std::string table = read_file(folder / "atlas/atlas.json");
  write_file_atomically(folder / "atlas/atlas.json",
                        replaced(table, "\"version\": 1", "\"version\": 2"));
  expect_complaint(render_with(folder / "atlas"), 1,
                   "atlas.json: version 2; this program reads version 1");
  write_file_atomically(folder / "atlas/atlas.json", table);
  const std::string layer = folder / "atlas/osc00.exr";
  write_file_atomically(layer, read_file(layer).substr(0, 5000));
  expect_complaint(render_with(folder / "atlas"), 1, "osc00.exr: ");
  expect_nothing_rendered();
}

TEST_F(Program, RenderNeedsAFolderThatCanBe) {
  PLUVIA_NEEDS_OPENGL();
  write_file_atomically(folder / "plain", "x");
  const std::string scene = write_scene("[environment]\nuniform_cd_m2 = [1, 1, 1]");
  expect_complaint(fmt::format("render {} --atlas {}/atlas --out {}/plain/f", scene, shared->path(),
                               folder.path()),
                   1, "Not a directory");
  EXPECT_EQ(read_file(folder / "plain"), "x");
}

TEST_F(Program, ValidateTellsMissingInputsBeforeItMeasures) {
  const auto validate = [&](const std::string& flags) {
    return fmt::format("validate {} --out {}/report", flags, folder.path());
  };
  const std::string atlas = fmt::format(" --atlas {}/atlas", shared->path());
  // As wide as the factors want it: what comes before the frame must pass.
  const std::string wide =
      write_preset(folder.path(),
                   replaced(replaced(tiny_preset, "width_px = 4", "width_px = 32"), "[80]", "[0]"));
  const std::string database = fmt::format("--database {}/db", folder.path());
  ASSERT_EQ(
      run_pluvia(fmt::format("generate {} --oscillations 0 --out {}/db", wide, folder.path())).code,
      0);
  expect_complaint(validate("--database " + (folder / "none") + atlas), 1,
                   "none/manifest.json: cannot read");
  expect_complaint(validate(database + " --atlas " + (folder / "none")), 1, "none/atlas.json");
  expect_complaint(validate(database + atlas + " --scene " + (folder / "none.toml")), 1,
                   "none.toml: cannot read");
  expect_complaint(validate(database + atlas + " --data " + (folder / "none")), 1,
                   "none/presets/gn2006.toml: cannot read");
}

}  // namespace
}  // namespace pluvia
