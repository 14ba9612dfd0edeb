// The viewer's controls as a hand meets them, without a window: keys and the mouse are told to Dear
// ImGui itself.
#include <gtest/gtest.h>

#include <imgui.h>

#include "realtime/viewer/panel.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

constexpr float wide_px = 640, high_px = 480;

// Dear ImGui over a viewer's frames of 160 x 120 px in a window of 640 x 480.
class Panel : public testing::Test {
 protected:
  void SetUp() override {
    PLUVIA_NEEDS_OPENGL();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {wide_px, high_px};
    io.DeltaTime = 0.05f;
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    viewer = make_viewer(std::make_shared<GlContext>(), rainy_scene(300), quarter_atlas(), {}, 0.5,
                         folder.path());
    panel.shown = false;
    draw();
  }
  void TearDown() override {
    if (ImGui::GetCurrentContext()) ImGui::DestroyContext();
  }

  void draw() {
    const GlTexture target = make_texture(GL_RGBA8, 160, 120);
    const GlFramebuffer framebuffer = make_framebuffer({target.id()}, 0);
    draw_viewer(viewer, is_settled(), framebuffer.id(), 160, 120);
  }
  // A frame with the mouse there.
  FlyInput frame(const Eigen::Vector2d& mouse, bool pressed, const WindowKeys& keys = {}) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {static_cast<float>(mouse.x()), static_cast<float>(mouse.y())};
    io.MouseDown[0] = pressed;
    ImGui::NewFrame();
    take_keys(viewer, panel, keys);
    show_panel(viewer, panel);
    const FlyInput input = fly_input(panel, keys);
    ImGui::Render();
    return input;
  }

  const TemporaryFolder folder;
  Viewer viewer = {};
  PanelState panel = {};
};

TEST_F(Panel, AHandleDragsItsLampAndTheCameraStays) {
  const Eigen::Vector3d lamp = viewer.edits.lights[0].position_m;
  const auto seen = seen_at_px(viewer.camera, lamp);
  ASSERT_TRUE(seen);
  const Eigen::Vector2d there = 4 * *seen;  // four pixels of the window for one of the picture
  frame(there, false);
  frame(there, true);
  const FlyInput input = frame(there + Eigen::Vector2d(40, -24), true);
  EXPECT_TRUE(input.turn_rad.isZero(0));
  const auto moved = seen_at_px(viewer.camera, viewer.edits.lights[0].position_m);
  ASSERT_TRUE(moved);
  EXPECT_LT((*moved - *seen - Eigen::Vector2d(10, -6)).norm(), 1e-10);
  EXPECT_EQ(viewer.edits.lights[1].position_m, viewer.scene.lights[1].position_m);
  frame(there, false);
  frame({5, 5}, false);
  EXPECT_LT((*seen_at_px(viewer.camera, viewer.edits.lights[0].position_m) - *moved).norm(), 1e-12);
}

TEST_F(Panel, ADragBesideTheHandlesTurnsTheCamera) {
  frame({300, 400}, false);
  frame({300, 400}, true);
  const FlyInput input = frame({320, 390}, true);
  EXPECT_GT(input.turn_rad.x(), 0);
  EXPECT_NEAR(input.turn_rad.y(), input.turn_rad.x() / 2, 1e-9);
  EXPECT_TRUE(frame({360, 390}, false).turn_rad.isZero(0));
}

TEST_F(Panel, TakesTheMouseThatIsOverIt) {
  panel.shown = true;
  for (int i = 0; i < 3; ++i) frame({100, 200}, false);
  frame({100, 200}, true);
  EXPECT_TRUE(frame({120, 210}, true).turn_rad.isZero(0));
}

TEST_F(Panel, AKeyThatIsHeldActsOnce) {
  const WindowKeys none, p = {.panel = true}, space = {.clock = true}, r = {.record = true};
  for (int i = 0; i < 3; ++i) frame({300, 400}, false, p);
  EXPECT_TRUE(panel.shown);
  frame({300, 400}, false, none);
  frame({300, 400}, false, p);
  EXPECT_FALSE(panel.shown);
  frame({300, 400}, false, space);
  EXPECT_EQ(viewer.time_scale, 0);
  frame({300, 400}, false, none);
  frame({300, 400}, false, space);
  EXPECT_EQ(viewer.time_scale, 1);
  for (int i = 0; i < 2; ++i) frame({300, 400}, false, r);
  EXPECT_TRUE(viewer.recording);
  EXPECT_EQ(viewer.path.size(), 1u);
}

TEST_F(Panel, MovingKeysAreHeldAndShiftIsFourTimesAsFast) {
  const WindowKeys keys = {.move = {1, -1, 0}, .fast = true};
  frame({300, 400}, false, keys);
  const FlyInput input = frame({300, 400}, false, keys);
  EXPECT_EQ(input.move, Eigen::Vector3d(1, -1, 0));
  EXPECT_EQ(input.speed_m_s, 8);
}

TEST_F(Panel, ScreenshotsSayWhereTheyAreOrWhyNot) {
  frame({300, 400}, false, {.screenshot = true});
  EXPECT_EQ(viewer.message, folder / "shot_0000.exr, .png");
  viewer.out_folder = "/dev/null/shots";
  frame({300, 400}, false);
  frame({300, 400}, false, {.screenshot = true});
  EXPECT_NE(viewer.message.find("/dev/null/shots: cannot create"), std::string::npos);
}

TEST_F(Panel, WindPrimitivesHaveControlsAndTheWindItsLines) {
  Scene scene = rainy_scene(300);
  scene.rain.wind = {{.kind = WindKind::vortex, .position_m = {1, 4, 0}, .strength = 20}};
  viewer = make_viewer(viewer.context, scene, quarter_atlas(), {}, 0.5, folder.path());
  draw();
  const auto lines_drawn = [&] {
    frame({300, 400}, false);
    return ImGui::GetDrawData()->TotalVtxCount;
  };
  const int without = lines_drawn();
  panel.streamlines = true;
  EXPECT_GT(lines_drawn(), without + 1000);
  panel.shown = true;
  for (int i = 0; i < 3; ++i) frame({300, 400}, false);
  const Frame before = viewer.renderer->render(0.6);
  viewer.edits.wind[0].strength = -20;
  draw();
  EXPECT_EQ(viewer.made.wind[0].strength, 20) << "the renderer stays";
  const Frame after = viewer.renderer->render(0.7);
  viewer.edits.wind[0].strength = 20;
  EXPECT_NE(before.rain.values, after.rain.values);
}

TEST_F(Panel, IsDrawnForEveryScene) {
  // All of it open, for scenes with and without what its controls are about.
  panel.shown = panel.packet_map = true;
  Scene storm = rainy_scene(300), dry;
  storm.fog = Fog{.extinction_per_m = 0.01};
  storm.glow = Glow{};
  storm.splashes = Splashes{};
  storm.camera.depth_of_field = DepthOfField{.aperture_m = 0.01};
  storm.lights.push_back({.name = "sun", .kind = LightKind::sun});
  storm.lights.back().illuminance_lux = {5, 5, 5};
  storm.rain.sizes.push_back({.r0_m = 5e-4, .drops_per_m3 = 1, .velocity_m_s = {1, 0, -4}});
  dry.camera = storm.camera;
  for (const Scene& scene : {storm, dry}) {
    viewer = make_viewer(viewer.context, scene, quarter_atlas(), {}, 0.5, folder.path());
    draw();
    for (int i = 0; i < 3; ++i) frame({300, 400}, false);
    EXPECT_GT(ImGui::GetDrawData()->TotalVtxCount, 1000);
    EXPECT_EQ(needs_remake(viewer.made, viewer.edits), "") << "looking changes nothing";
  }
}

}  // namespace
}  // namespace pluvia
