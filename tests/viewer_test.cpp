// The viewer without a window: its camera, its edits, its recording, its frames.
#include <cmath>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "atlas/atomic_file.h"
#include "atlas/image_io.h"
#include "realtime/viewer/camera_recording.h"
#include "realtime/viewer/packet_map.h"
#include "realtime/viewer/streamlines.h"
#include "realtime/viewer/viewer.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

Camera some_camera() {
  return {.position_m = {1, 2, 1.6}, .target_m = {4, 6, 1.6}, .width_px = 200, .height_px = 100};
}

TEST(FlyCamera, StaysToTheBitWithoutInput) {
  const Camera camera = {.position_m = {0.1, 0.2, 0.3}, .target_m = {1.0 / 3, 20, 4.6}};
  const Camera after = fly(camera, {}, 0.04);
  EXPECT_EQ(after.position_m, camera.position_m);
  EXPECT_EQ(after.target_m, camera.target_m);
}

TEST(FlyCamera, MovesAlongItsViewAndUpTheWorld) {
  const Camera camera = some_camera();  // looks along (3, 4, 0) / 5; right is (4, -3, 0) / 5
  const auto moved = [&](const Eigen::Vector3d& move) -> Eigen::Vector3d {
    const Camera after = fly(camera, {.move = move, .speed_m_s = 10}, 0.5);
    EXPECT_LT(((after.target_m - after.position_m) - Eigen::Vector3d(3, 4, 0)).norm(), 1e-12);
    return after.position_m - camera.position_m;
  };
  EXPECT_LT((moved({0, 1, 0}) - Eigen::Vector3d(3, 4, 0)).norm(), 1e-12);
  EXPECT_LT((moved({1, 0, 0}) - Eigen::Vector3d(4, -3, 0)).norm(), 1e-12);
  EXPECT_LT((moved({0, 0, -1}) - Eigen::Vector3d(0, 0, -5)).norm(), 1e-12);
}

TEST(FlyCamera, TurnsAroundItsPlaceAndNeverOverTheTop) {
  const Camera camera = some_camera();
  const Camera right = fly(camera, {.turn_rad = {pi / 2, 0}}, 1);
  EXPECT_EQ(right.position_m, camera.position_m);
  EXPECT_LT((right.target_m - camera.position_m - Eigen::Vector3d(4, -3, 0)).norm(), 1e-12);
  const Camera up = fly(camera, {.turn_rad = {0, 0.3}}, 1);
  const Eigen::Vector3d way = up.target_m - camera.position_m;
  EXPECT_NEAR(way.norm(), 5, 1e-12);
  EXPECT_NEAR(way.z() / 5, std::sin(0.3), 1e-12);
  for (const double pitch : {10.0, -10.0}) {
    const Camera steep = fly(camera, {.turn_rad = {0, pitch}}, 1);
    const double z = (steep.target_m - steep.position_m).normalized().z();
    EXPECT_NEAR(z, std::copysign(std::sin(steepest_rad), pitch), 1e-12);
  }
}

TEST(FlyCamera, ADraggedPointIsSeenWhereItWasDraggedAndAsFarAway) {
  const Camera camera = some_camera();
  const Eigen::Vector3d lamp(3, 8, 4);
  const auto before = seen_at_px(camera, lamp);
  ASSERT_TRUE(before);
  EXPECT_LT((dragged_to(camera, lamp, *before) - lamp).norm(), 1e-12);
  const Eigen::Vector3d moved = dragged_to(camera, lamp, {30, 70});
  const auto after = seen_at_px(camera, moved);
  ASSERT_TRUE(after);
  EXPECT_LT((*after - Eigen::Vector2d(30, 70)).norm(), 1e-10);
  const Eigen::Vector3d forward = camera_frame(camera).forward;
  EXPECT_NEAR((moved - lamp).dot(forward), 0, 1e-12);
  // The middle of the picture is the target; behind the camera nothing is seen.
  EXPECT_LT((*seen_at_px(camera, camera.target_m) - Eigen::Vector2d(100, 50)).norm(), 1e-10);
  EXPECT_FALSE(seen_at_px(camera, {-3, -3, 1.6}));
}

TEST(CameraRecording, IsReadBackToTheBit) {
  Camera camera = some_camera();
  camera.vertical_fov_deg = 51.7;
  camera.exposure_s = 1.0 / 60;
  camera.white_cd_m2 = 2.5e-7;
  camera.depth_of_field = DepthOfField{.aperture_m = 0.0123, .focus_m = 2};
  std::vector<CameraKey> path;
  for (int i = 0; i < 40; ++i) {
    record_key(path, camera, 1.25 + i / 24.0, 0.5);
    camera.depth_of_field->focus_m = 1 + i / 3.0;
    camera = fly(camera, {.move = {0.3, 1, 0.1}, .turn_rad = {0.05, -0.01}}, 1.0 / 24);
  }
  record_key(path, camera, 1e6 / 3, least_key_s);
  EXPECT_EQ(path.size(), 5u);  // at 0, 12, 24 and 36 frames of 1/24 s, and the last
  const TemporaryFolder folder;
  write_file_atomically(folder / "path.toml", camera_path_toml(camera, path));
  const Scene scene = read_scene(folder / "path.toml");
  ASSERT_EQ(scene.camera_path.size(), path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(scene.camera_path[i].time_s, path[i].time_s);
    EXPECT_EQ(scene.camera_path[i].position_m, path[i].position_m);
    EXPECT_EQ(scene.camera_path[i].target_m, path[i].target_m);
    EXPECT_EQ(scene.camera_path[i].focus_m, path[i].focus_m);
  }
  EXPECT_EQ(scene.camera.vertical_fov_deg, camera.vertical_fov_deg);
  EXPECT_EQ(scene.camera.exposure_s, camera.exposure_s);
  EXPECT_EQ(scene.camera.depth_of_field->aperture_m, 0.0123);
  EXPECT_EQ(scene.camera.white_cd_m2, camera.white_cd_m2);
  EXPECT_EQ(scene.camera.width_px, 200);
  EXPECT_EQ(scene.camera.height_px, 100);
}

TEST(CameraRecording, OfOneKeyIsNoPath) {
  EXPECT_EQ(message_of([] { camera_path_toml({}, {CameraKey{}}); }),
            "camera path: 1 key; expected 2 or more");
}

TEST(CameraRecording, KeysKeepTheirDistanceAlsoWhenTheClockIsTurnedBack) {
  std::vector<CameraKey> path;
  for (const double time_s : {3.0, 3.2, 2.0, 3.5, 3.5004}) record_key(path, {}, time_s, 0.5);
  ASSERT_EQ(path.size(), 2u);
  EXPECT_EQ(path[1].time_s, 3.5);
}

TEST(SceneEdits, NoneLeaveTheSceneAsItIs) {
  const Scene scene = read_scene(PLUVIA_SOURCE_DIR "/data/scenes/storm.toml");
  const Scene same = edited_scene(scene, edits_of(scene, {}));
  ASSERT_EQ(same.rain.sizes.size(), scene.rain.sizes.size());
  for (std::size_t i = 0; i < same.rain.sizes.size(); ++i) {
    EXPECT_EQ(same.rain.sizes[i].drops_per_m3, scene.rain.sizes[i].drops_per_m3);
    EXPECT_EQ(same.rain.sizes[i].velocity_m_s, scene.rain.sizes[i].velocity_m_s);
  }
  EXPECT_EQ(same.rain.undrawn_per_m, scene.rain.undrawn_per_m);
  EXPECT_EQ(same.fog->extinction_per_m, scene.fog->extinction_per_m);
  EXPECT_TRUE(same.glow);
  EXPECT_EQ(same.lights.size(), scene.lights.size());
  EXPECT_EQ(needs_remake(edits_of(scene, {}), edits_of(scene, {})), "");
}

TEST(SceneEdits, RateAndWindAreThoseThatTheSceneHasAfterwards) {
  const Scene scene = read_scene(PLUVIA_SOURCE_DIR "/data/scenes/storm.toml");
  SceneEdits edits = edits_of(scene, {});
  EXPECT_EQ(edits.wind_m_s, Eigen::Vector3d(9, 2, 0));
  // 8 drops of 3.2 mm in a cubic metre that fall 8.49 m/s, as street.toml says.
  const Scene street = read_scene(PLUVIA_SOURCE_DIR "/data/scenes/street.toml");
  EXPECT_NEAR(rate_mm_h(street.rain), 8 * pi / 6 * 3.2e-3 * 3.2e-3 * 3.2e-3 * 8.49 * 3.6e6, 1e-12);
  edits.rate_mm_h = 13;
  edits.wind_m_s = {-3, 0, 0};
  const Rain rain = edited_scene(scene, edits).rain;
  EXPECT_NEAR(rate_mm_h(rain), 13, 1e-12);
  EXPECT_EQ(rain.wind_m_s, Eigen::Vector3d(-3, 0, 0));
  for (std::size_t i = 0; i < rain.sizes.size(); ++i)
    EXPECT_LT((rain.sizes[i].velocity_m_s - scene.rain.sizes[i].velocity_m_s -
               Eigen::Vector3d(-12, -2, 0))
                  .norm(),
              1e-12);
  EXPECT_NEAR(rain.undrawn_per_m / scene.rain.undrawn_per_m, 13 / rate_mm_h(scene.rain), 1e-12);
  edits.rate_mm_h = 0;
  EXPECT_TRUE(edited_scene(scene, edits).rain.sizes.empty());
  edits.wind_m_s = {0, 0, 20};
  EXPECT_NE(message_of([&] { edited_scene(scene, edits); }).find("expected a fall of 0.01 m/s"),
            std::string::npos);
}

TEST(SceneEdits, WindPrimitivesAreEditedWithoutANewRenderer) {
  Scene scene;
  scene.rain.wind = {{.kind = WindKind::vortex, .strength = 5}};
  SceneEdits edits = edits_of(scene, {});
  edits.wind[0].strength = 9;
  EXPECT_EQ(edited_scene(scene, edits).rain.wind[0].strength, 9);
  EXPECT_EQ(needs_remake(edits_of(scene, {}), edits), "");
}

TEST(Streamlines, OfAVortexAreCirclesAndOfAnEvenWindStraight) {
  Wind wind;
  wind.primitives = {{.kind = WindKind::vortex, .strength = 5, .core_radius_m = 0.5}};
  const Eigen::Vector3d low(-9, -9, -9), high(9, 9, 9);
  const int steps = 200;
  const auto circle = streamline(wind, {2, 0, 1}, 2 * pi * 2 / steps, steps, low, high);
  ASSERT_EQ(circle.size(), 201u);
  // Of the fourth order: once around by (2 pi / 200)^4 / 120 of a radius a radian.
  for (const Eigen::Vector3d& at : circle) EXPECT_NEAR(at.head<2>().norm(), 2, 1e-6);
  EXPECT_LT((circle.back() - circle.front()).norm(), 1e-5);
  const auto straight = streamline({.even_m_s = {3, 4, 0}}, {0, 0, 0}, 1, 100, low, high);
  EXPECT_EQ(straight.size(), 12u) << "until it leaves the box";
  EXPECT_LT((straight.back() - Eigen::Vector3d(6.6, 8.8, 0)).norm(), 1e-12);
  EXPECT_EQ(streamline({}, {0, 0, 0}, 1, 100, low, high).size(), 1u) << "the air stands";
}

TEST(Streamlines, ATurnAndItsAxisAreOne) {
  for (const double tilt : {20.0, 90.0, 150.0}) {
    for (const double heading : {-170.0, -20.0, 45.0, 100.0}) {
      const Turn turn = turn_of(axis_of({tilt, heading}));
      EXPECT_NEAR(turn.tilt_deg, tilt, 1e-12);
      EXPECT_NEAR(turn.heading_deg, heading, 1e-12);
    }
  }
  EXPECT_LT((axis_of({90, 90}) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-15) << "to the east";
}

TEST(SceneEdits, AnEffectThatIsOffIsNotInTheScene) {
  Scene scene = rainy_scene(100);
  scene.lights[0].shadow = true;
  SceneEdits edits = edits_of(scene, {});
  EXPECT_FALSE(edited_scene(scene, edits).fog);
  edits.glow = true;
  EXPECT_FALSE(edited_scene(scene, edits).glow) << "glow needs fog";
  edits.fog = true;
  EXPECT_TRUE(edited_scene(scene, edits).glow);
  EXPECT_FALSE(edited_scene(scene, edits).splashes);
  edits.splashes = true;
  EXPECT_TRUE(edited_scene(scene, edits).splashes);
  edits.rain = edits.shadows = false;  // and splashes need rain
  const Scene off = edited_scene(scene, edits);
  EXPECT_TRUE(off.rain.sizes.empty());
  EXPECT_FALSE(off.splashes);
  EXPECT_FALSE(off.lights[0].shadow);
}

struct NamedEdit {
  std::string reason = {};  // to make the renderer anew; "": none
  bool seen = true;         // in the picture
  SceneEdits edits = {};
};

// Every edit of the panel.
std::vector<NamedEdit> all_edits(const SceneEdits& none) {
  std::vector<NamedEdit> edits;
  const auto add = [&](const char* reason, auto change, bool seen = true) {
    edits.push_back({reason, seen, none});
    change(edits.back().edits);
  };
  add(
      "", [](SceneEdits& e) { e.white_cd_m2 = 7; }, false);  // about the window alone
  add("", [](SceneEdits& e) { e.lights[1].position_m.x() += 1; });
  add("", [](SceneEdits& e) { e.lights[0].intensity_cd *= 2; });
  add("a light with a shadow", [](SceneEdits& e) { e.lights[0].position_m.x() += 1; });
  add("rate", [](SceneEdits& e) { e.rate_mm_h *= 2; });
  add("wind", [](SceneEdits& e) { e.wind_m_s.x() += 2; });
  add("exposure", [](SceneEdits& e) { e.exposure_s *= 2; });
  add("field of view", [](SceneEdits& e) { e.vertical_fov_deg = 60; });
  add("rain", [](SceneEdits& e) { e.rain = false; });
  add("splashes", [](SceneEdits& e) { e.splashes = false; });
  add("", [](SceneEdits& e) { e.focus_m = 9; });
  add("depth of field", [](SceneEdits& e) { e.depth_of_field = false; });
  add("depth of field", [](SceneEdits& e) { e.aperture_m = 0.05; });
  add("shadows", [](SceneEdits& e) { e.shadows = false; });
  add("fog", [](SceneEdits& e) { e.fog = false; });
  add("glow", [](SceneEdits& e) { e.glow = false; });
  add("mist", [](SceneEdits& e) { e.air.extinction_per_m = 0.1; });
  add("quality", [](SceneEdits& e) { e.options.lookup = LookupMode::trilinear; });
  add("quality", [](SceneEdits& e) { e.options.widest_splat_px = 0; });
  add(
      "quality", [](SceneEdits& e) { e.options.packets.scheme = PacketScheme::world; }, false);
  add("size of a pixel", [](SceneEdits& e) { e.pixel_px = 2; });
  // Last: what is made for it adds up in finer quanta than what is made for the scene's own.
  add("white", [](SceneEdits& e) { e.white_cd_m2 = 0.1; });
  return edits;
}

Scene full_scene() {
  Scene scene = rainy_scene(800);
  scene.lights[0].shadow = true;
  add_rectangle(scene.mesh, {-1, 6, 0}, {2, 0, 0}, {0, 0, 2}, {.base_color = {0.5, 0.5, 0.5}});
  scene.fog = Fog{.extinction_per_m = 0.02};
  scene.glow = Glow{};
  scene.splashes = Splashes{};
  scene.camera.depth_of_field = DepthOfField{.aperture_m = 0.03, .focus_m = 4};
  return scene;
}

TEST(SceneEdits, WhatIsSeenAnewIsWhatAsksForANewRenderer) {
  const SceneEdits none = edits_of(full_scene(), {});
  for (const NamedEdit& edit : all_edits(none))
    EXPECT_EQ(needs_remake(none, edit.edits), edit.reason);
}

// The viewer's frame, read back.
Frame frame_of(Viewer& viewer, int width, int height) {
  viewer.context->make_current();
  const GlTexture target = make_texture(GL_RGBA8, width, height);
  const GlFramebuffer framebuffer = make_framebuffer({target.id()}, 0);
  EXPECT_TRUE(draw_viewer(viewer, true, framebuffer.id(), width, height));
  Frame frame = viewer.frame;
  viewer.renderer->read(frame);
  return frame;
}

TEST(Viewer, ShowsEveryEditAsIfTheSceneHadAlwaysBeenSo) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = full_scene();
  const auto context = std::make_shared<GlContext>();
  Viewer viewer = make_viewer(context, scene, quarter_atlas(), {}, 0.5, "");
  const Frame before = frame_of(viewer, 160, 120);
  for (const NamedEdit& edit : all_edits(viewer.edits)) {
    viewer.edits = edit.edits;
    const Frame found = frame_of(viewer, 160, 120);
    Viewer fresh = make_viewer(context, scene, quarter_atlas(), {}, 0.5, "");
    fresh.edits = edit.edits;
    if (edit.seen) {
      EXPECT_EQ(found.color.values, frame_of(fresh, 160, 120).color.values) << edit.reason;
    }
    EXPECT_EQ(found.color.values != before.color.values, edit.seen) << edit.reason;
  }
}

TEST(Viewer, ShowsTheFrameThatIsRendered) {
  PLUVIA_NEEDS_OPENGL();
  // Its rain space does not hang on the view: the scene gives radius and height.
  const Scene scene = full_scene();
  Viewer viewer = make_viewer(std::make_shared<GlContext>(), scene, quarter_atlas(), {}, 0.5, "");
  EXPECT_EQ(frame_of(viewer, 160, 120).color.values,
            RainRenderer(scene, quarter_atlas()).render(0.5).color.values);
}

TEST(Viewer, AWindowOfNoSizeDrawsNothingAndOneOfAnotherSizeAllOfIt) {
  PLUVIA_NEEDS_OPENGL();
  Viewer viewer =
      make_viewer(std::make_shared<GlContext>(), rainy_scene(800), quarter_atlas(), {}, 0.5, "");
  EXPECT_FALSE(draw_viewer(viewer, true, 0, 0, 0));
  EXPECT_FALSE(draw_viewer(viewer, true, 0, 160, 0));
  EXPECT_FALSE(viewer.renderer);
  EXPECT_EQ(frame_of(viewer, 160, 120).color.width, 160);
  EXPECT_FALSE(draw_viewer(viewer, true, 0, 0, 0));
  const Frame wide = frame_of(viewer, 301, 77);
  EXPECT_EQ(wide.color.width, 301);
  EXPECT_EQ(wide.color.height, 77);
  EXPECT_TRUE(all_finite(frame_of(viewer, 1, 1).color));
  viewer.edits.pixel_px = 4;
  const Frame coarse = frame_of(viewer, 301, 77);
  EXPECT_EQ(coarse.color.width, 76);
  EXPECT_EQ(coarse.color.height, 20);
  EXPECT_TRUE(all_finite(coarse.color));
}

TEST(Viewer, AnEditThatIsRefusedIsUndoneAndSaidSo) {
  PLUVIA_NEEDS_OPENGL();
  Viewer viewer =
      make_viewer(std::make_shared<GlContext>(), rainy_scene(800), quarter_atlas(), {}, 0.5, "");
  const Frame before = frame_of(viewer, 160, 120);
  viewer.edits.exposure_s = 1e-5;
  EXPECT_EQ(frame_of(viewer, 160, 120).color.values, before.color.values);
  EXPECT_NE(viewer.message.find("in which a drop of"), std::string::npos) << viewer.message;
  EXPECT_EQ(viewer.edits.exposure_s, 1.0 / 60);
}

TEST(Viewer, AnotherLookIsThatOfARendererMadeForIt) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(800);
  Viewer viewer = make_viewer(std::make_shared<GlContext>(), scene, quarter_atlas(), {}, 0.5, "");
  const Frame traced = frame_of(viewer, 160, 120);
  viewer.edits.options.look = StreakLook::sphere;
  const Frame sphere = frame_of(viewer, 160, 120);
  EXPECT_EQ(viewer.message, "");
  EXPECT_NE(sphere.color.values, traced.color.values);
  RenderOptions options;
  options.look = StreakLook::sphere;
  Viewer other =
      make_viewer(std::make_shared<GlContext>(), scene, quarter_atlas(), options, 0.5, "");
  EXPECT_EQ(frame_of(other, 160, 120).color.values, sphere.color.values);
  viewer.edits.options.look = StreakLook::refraction;  // without masks
  EXPECT_EQ(frame_of(viewer, 160, 120).color.values, sphere.color.values);
  EXPECT_EQ(viewer.edits.options.look, StreakLook::sphere);
  EXPECT_NE(viewer.message, "");
  viewer.edits.options.look = StreakLook::traced;
  EXPECT_EQ(frame_of(viewer, 160, 120).color.values, traced.color.values);
}

TEST(Viewer, WaitsWithANewRendererWhileASliderIsHeld) {
  PLUVIA_NEEDS_OPENGL();
  Viewer viewer =
      make_viewer(std::make_shared<GlContext>(), rainy_scene(800), quarter_atlas(), {}, 0.5, "");
  frame_of(viewer, 160, 120);
  const long streaks = viewer.frame.streaks_in_view;
  viewer.edits.rate_mm_h *= 3;
  const GlTexture target = make_texture(GL_RGBA8, 160, 120);
  const GlFramebuffer framebuffer = make_framebuffer({target.id()}, 0);
  draw_viewer(viewer, false, framebuffer.id(), 160, 120);
  EXPECT_EQ(viewer.frame.streaks_in_view, streaks);
  draw_viewer(viewer, true, framebuffer.id(), 160, 120);
  EXPECT_GT(viewer.frame.streaks_in_view, 2 * streaks);
}

TEST(Viewer, FarFromWhereItWasMadeTheRainIsMadeAnew) {
  PLUVIA_NEEDS_OPENGL();
  Viewer viewer =
      make_viewer(std::make_shared<GlContext>(), rainy_scene(800), quarter_atlas(), {}, 0.5, "");
  frame_of(viewer, 160, 120);
  const Eigen::Vector3d start = viewer.made_at_m;
  advance(viewer, {.move = {0, 1, 0}, .speed_m_s = 40}, 0.1, 0.6);  // 4 of 20 m
  frame_of(viewer, 160, 120);
  EXPECT_EQ(viewer.made_at_m, start);
  advance(viewer, {.move = {0, 1, 0}, .speed_m_s = 40}, 5, 6);  // a slow frame: as in 0.2 s
  EXPECT_NEAR((viewer.camera.position_m - start).norm(), 12, 1e-12);
  frame_of(viewer, 160, 120);
  EXPECT_EQ(viewer.made_at_m, viewer.camera.position_m);
}

TEST(Viewer, ReplaysWhatItRecorded) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Viewer viewer = make_viewer(std::make_shared<GlContext>(), rainy_scene(100), quarter_atlas(), {},
                              2, folder.path());
  start_recording(viewer);
  for (int i = 1; i <= 30; ++i)
    advance(viewer, {.move = {0, 1, 0}, .turn_rad = {0.01, 0}}, 0.1, 2 + 0.1 * i);
  stop_recording(viewer);
  EXPECT_EQ(viewer.path.front().time_s, 2);
  EXPECT_NEAR(viewer.path.back().time_s, 5, 1e-9);
  const Camera end = viewer.camera;
  EXPECT_EQ(save_path(viewer), folder / "path_0000");
  EXPECT_EQ(save_path(viewer), folder / "path_0001");
  EXPECT_EQ(read_scene(folder / "path_0001.toml").camera_path.size(), viewer.path.size());
  start_replay(viewer);
  EXPECT_EQ(viewer.time_s, 2);
  advance(viewer, {}, 0.1, viewer.path[2].time_s);
  EXPECT_LT((viewer.camera.position_m - viewer.path[2].position_m).norm(), 1e-9);
  advance(viewer, {}, 0.1, 10);
  EXPECT_EQ(viewer.camera.position_m, end.position_m);
  EXPECT_FALSE(viewer.replaying);
  start_replay(viewer);
  advance(viewer, {.move = {1, 0, 0}}, 0.1, 2.1);
  EXPECT_FALSE(viewer.replaying) << "a hand on the camera ends it";
}

TEST(Viewer, AScreenshotIsWhatRenderWrites) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  const Scene scene = rainy_scene(800);
  Viewer viewer =
      make_viewer(std::make_shared<GlContext>(), scene, quarter_atlas(), {}, 0.5, folder / "shots");
  frame_of(viewer, 160, 120);
  EXPECT_EQ(save_screenshot(viewer), folder / "shots/shot_0000");
  EXPECT_EQ(save_screenshot(viewer), folder / "shots/shot_0001");
  const Image color = RainRenderer(scene, quarter_atlas()).render(0.5).color;
  write_exr(folder / "frame.exr", color);
  write_png(folder / "frame.png", color, scene.camera.white_cd_m2);
  EXPECT_EQ(read_file(folder / "shots/shot_0001.exr"), read_file(folder / "frame.exr"));
  EXPECT_EQ(read_file(folder / "shots/shot_0001.png"), read_file(folder / "frame.png"));
  write_file_atomically(folder / "plain", "x");
  viewer.out_folder = folder / "plain/shots";
  EXPECT_NE(message_of([&] { save_screenshot(viewer); }).find("plain/shots: cannot create"),
            std::string::npos);
}

TEST(PacketMap, HasThePacketsThatTheFrameTakesAroundWhatItSees) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(20000);
  Viewer viewer = make_viewer(std::make_shared<GlContext>(), scene, quarter_atlas(),
                              {.packets = {.scheme = PacketScheme::tree}}, 0.5, "");
  frame_of(viewer, 160, 120);
  const PacketMap map = packet_map(scene.rain, viewer.renderer->rain_space(),
                                   *viewer.renderer->rain_packets(), viewer.camera, 0.5, 0);
  EXPECT_EQ(static_cast<long>(map.taken.size()), viewer.frame.packets.packets_taken);
  EXPECT_GT(map.taken.size(), 1u);
  // A fall straight down: the map is the ground.
  EXPECT_EQ(map.camera_m, Eigen::Vector2d(0.3, -0.4));
  EXPECT_EQ(map.radius_m, 20);
  EXPECT_EQ(map.box.low_m, Eigen::Vector2d(-6, -6));
  EXPECT_EQ(map.box.high_m, Eigen::Vector2d(6, 12));
  ASSERT_GE(map.shadow.size(), 3u);
  const Eigen::Vector2d ahead(1.5, 8);  // in the picture and in the box
  EXPECT_EQ(std::count_if(map.taken.begin(), map.taken.end(),
                          [&](const MapRectangle& r) {
                            return (ahead.array() >= r.low_m.array()).all() &&
                                   (ahead.array() < r.high_m.array()).all();
                          }),
            1);
}

}  // namespace
}  // namespace pluvia
