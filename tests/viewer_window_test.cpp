// The viewer in a real window, on a display without a screen.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/image_io.h"
#include "realtime/viewer/viewer.h"
#include "realtime/viewer/window.h"
#include "tests/realtime_fixture.h"
#include "tests/run_program.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"
#include "tests/x_server.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

#define PLUVIA_NEEDS_DISPLAY() \
  PLUVIA_NEEDS_OPENGL();       \
  const XServer display;       \
  if (!display.started()) GTEST_SKIP() << "no Xvfb; expected the package xvfb"

class ViewerWindow : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = std::make_unique<TemporaryFolder>();
    StreakAtlas atlas = quarter_atlas();
    atlas.diameter_um = 3200;
    write_atlas(*shared / "atlas", atlas);
    // Radius and height given: the rain space does not hang on the view.
    write_file_atomically(
        *shared / "scene.toml",
        "[camera]\nposition_m = [0, 0, 1.6]\ntarget_m = [0, 5, 1.6]\nwidth_px = 96\nheight_px = "
        "54\n"
        "white_cd_m2 = 3\n[environment]\nuniform_cd_m2 = [1, 1.5, 2]\n[rain]\ndrops_per_m3 = 80\n"
        "box_min_m = [-2, 1, 0]\nbox_max_m = [2, 4, 4]\nculling_radius_m = 8\nlocal_height_m = "
        "4\n");
  }
  static void TearDownTestSuite() { shared.reset(); }

  std::string flags(const std::string& command) const {
    return fmt::format("{} {}/scene.toml --atlas {}/atlas ", command, shared->path(),
                       shared->path());
  }
  void expect_complaint(const std::string& arguments, const std::string& line) const {
    const Outcome outcome = run_pluvia(arguments);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.err, MatchesRegex(line + "\n"));
    EXPECT_EQ(outcome.out, "");
  }

  static std::unique_ptr<TemporaryFolder> shared;
  const TemporaryFolder folder;
};

std::unique_ptr<TemporaryFolder> ViewerWindow::shared;

TEST_F(ViewerWindow, LeavesTheFrameThatIsRendered) {
  PLUVIA_NEEDS_DISPLAY();
  const Outcome seen =
      run_pluvia(flags("view") + "--width-px 96 --height-px 54 --frames 3 --out " + folder.path());
  ASSERT_EQ(seen.code, 0) << seen.err;
  const Outcome rendered = run_pluvia(flags("render") + "--frames 3 --out " + (folder / "frames"));
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  for (const char* ending : {".exr", ".png"})
    EXPECT_EQ(read_file(folder / "shot_0000" + ending),
              read_file(folder / "frames/frame_0002" + ending))
        << ending;
}

TEST_F(ViewerWindow, FollowsTheScenesPath) {
  PLUVIA_NEEDS_DISPLAY();
  const std::string still = read_file(*shared / "scene.toml");
  const std::string places = "position_m = [0, 0, 1.6]\ntarget_m = [0, 5, 1.6]\n";
  std::string moving = still;
  moving.replace(moving.find(places), places.size(), "");
  moving.insert(moving.find("[environment]"),
                "[[camera.key]]\ntime_s = 1\n" + places +
                    "[[camera.key]]\ntime_s = 1.2\nposition_m = [0.5, 0.1, 1.7]\n"
                    "target_m = [0, 5, 2]\n");
  write_file_atomically(folder / "path.toml", moving);
  const std::string flags = fmt::format("{0}/path.toml --atlas {1}/atlas --frames 4 --out {0}/",
                                        folder.path(), shared->path());
  ASSERT_EQ(run_pluvia("view --width-px 96 --height-px 54 " + flags + "seen").code, 0);
  ASSERT_EQ(run_pluvia("render " + flags + "frames").code, 0);
  EXPECT_EQ(read_file(folder / "seen/shot_0000.exr"), read_file(folder / "frames/frame_0003.exr"));
}

TEST_F(ViewerWindow, ShowsThePictureAndAPanelOverIt) {
  PLUVIA_NEEDS_DISPLAY();
  const Outcome seen = run_pluvia(flags("view") + "--frames 1 --pixel-px 4 --out " + folder.path());
  ASSERT_EQ(seen.code, 0) << seen.err;
  const Image window = read_image(folder / "shot_0000_window.png");
  const Image picture = read_image(folder / "shot_0000.png");
  ASSERT_EQ(window.width, 1280);
  ASSERT_EQ(window.height, 720);
  ASSERT_EQ(picture.width, 320);
  int panel = 0;
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 1280; ++x) {
      // One step of 255: a shader computes in float what the PNG had in double.
      const bool same = std::abs(window.at(x, y, 1) - picture.at(x / 4, y / 4, 1)) < 1.01f / 255;
      if (x < 360)
        panel += same ? 0 : 1;
      else
        ASSERT_TRUE(same) << x << ", " << y;
    }
  }
  EXPECT_GT(panel, 360 * 720 / 2);
}

TEST_F(ViewerWindow, WithoutADisplayThereIsOneLine) {
  PLUVIA_NEEDS_OPENGL();
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  expect_complaint(flags("view") + "--frames 1", "pluvia view: window: .*; expected a display");
  setenv("DISPLAY", ":12345", 1);
  expect_complaint(flags("view") + "--frames 1", "pluvia view: window: .*; expected a display");
  unsetenv("DISPLAY");
}

TEST_F(ViewerWindow, AnOpenGlThatIsTooOldIsRefusedWithItsVersion) {
  PLUVIA_NEEDS_DISPLAY();
  // Mesa's drivers then claim to be no better; another driver has no such wish.
  setenv("MESA_GL_VERSION_OVERRIDE", "4.1", 1);
  const Outcome outcome = run_pluvia(flags("view") + "--frames 1 --out " + folder.path());
  unsetenv("MESA_GL_VERSION_OVERRIDE");
  if (outcome.code == 0) GTEST_SKIP() << "this driver cannot be made to offer OpenGL 4.1";
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              MatchesRegex("pluvia view: OpenGL: version 4\\.1 .*; expected OpenGL 4.5 "
                           "core\n"));
}

TEST_F(ViewerWindow, AFolderThatCannotBeIsOneLine) {
  PLUVIA_NEEDS_DISPLAY();
  write_file_atomically(folder / "plain", "x");
  expect_complaint(
      flags("view") + "--frames 1 --width-px 64 --height-px 36 --out " + (folder / "plain/shots"),
      "pluvia view: .*plain/shots: cannot create: .*");
}

TEST_F(ViewerWindow, ThePictureFollowsTheWindow) {
  PLUVIA_NEEDS_DISPLAY();
  Scene scene = rainy_scene(800);
  scene.camera.width_px = 417;
  scene.camera.height_px = 123;
  // Before the window: its context and one without a window are not current beside each other.
  const Image expected = RainRenderer(scene, quarter_atlas()).render(0.5).color;
  Window window("test", {320, 200});
  Viewer viewer = make_viewer(window.context(), rainy_scene(800), quarter_atlas(), {}, 0.5, "");
  const auto draw = [&] {
    const WindowSize size = window.size();
    EXPECT_TRUE(draw_viewer(viewer, true, 0, size.width_px, size.height_px));
    window.show();
    viewer.renderer->read(viewer.frame);
    return viewer.frame.color;
  };
  EXPECT_EQ(draw().width, 320);
  window.resize({417, 123});
  for (int i = 0; i < 200 && window.size().width_px != 417; ++i) window.take_events(0.05);
  const Image picture = draw();
  EXPECT_EQ(picture.width, 417);
  EXPECT_EQ(picture.height, 123);
  EXPECT_EQ(picture.values, expected.values);
}

}  // namespace
}  // namespace pluvia
