#include <filesystem>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/image_io.h"
#include "realtime/rain_renderer.h"
#include "realtime/shader.h"
#include "realtime/video.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"

namespace pluvia {
namespace {

const StreakAtlas& shared_atlas() {
  static const StreakAtlas atlas = synthetic_atlas({.layers = 5});
  return atlas;
}

template <class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no exception";
}

Scene wall_scene() {  // a wall 4 m before the camera, which looks at it from the south
  Scene scene;
  scene.camera.position_m = {100, 200, 3};
  scene.camera.target_m = {100, 204, 3};
  scene.camera.width_px = 65;
  scene.camera.height_px = 41;
  add_rectangle(scene.mesh, {90, 204, -7}, {20, 0, 0}, {0, 0, 20},
                {.base_color = {0.2, 0.4, 0.8}, .emission_cd_m2 = {1, 2, 3}});
  return scene;
}

TEST(SceneBackground, DepthIsTheDistanceAlongTheAxisAndInfiniteInTheSky) {
  PLUVIA_NEEDS_OPENGL();
  const Frame wall = RainRenderer(wall_scene(), {}).render(0);
  // A float holds 4 m to 2e-7 m; interpolation adds a few roundings.
  for (const float depth : wall.depth_m.values) EXPECT_NEAR(depth, 4, 4e-6);
  Scene empty = wall_scene();
  empty.mesh = {};
  for (const float depth : RainRenderer(empty, {}).render(0).depth_m.values)
    EXPECT_EQ(depth, std::numeric_limits<float>::infinity());
}

TEST(SceneBackground, ALambertWallShowsIntensityOverSquaredDistance) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = wall_scene();
  scene.lights = {{"lamp", {100, 202, 3}, {100, 200, 300}}};  // 2 m before the wall's middle
  scene.environment.uniform_cd_m2 = {0.5, 0.25, 0.125};
  const Frame frame = RainRenderer(scene, {}).render(0);
  for (int c = 0; c < 3; ++c) {
    const double albedo = scene.mesh.materials[0].base_color[c];
    const double expected = scene.mesh.materials[0].emission_cd_m2[c] +
                            albedo * scene.environment.uniform_cd_m2[c] +
                            albedo / std::numbers::pi * scene.lights[0].intensity_cd[c] / 4;
    // The middle pixel's four samples are 0.018 m off the foot of the lamp: cos^4 is 1 - 2e-4.
    EXPECT_NEAR(static_cast<double>(frame.background.at(32, 20, c)), expected, 3e-4 * expected);
  }
}

TEST(SceneBackground, ALampBehindAWallDoesNotLightIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = wall_scene();
  scene.lights = {{"lamp", {100, 206, 3}, {100, 200, 300}}};
  const Frame frame = RainRenderer(scene, {}).render(0);
  for (int c = 0; c < 3; ++c)
    EXPECT_FLOAT_EQ(frame.background.at(32, 20, c),
                    static_cast<float>(scene.mesh.materials[0].emission_cd_m2[c]));
}

TEST(SceneBackground, TheSkyReadsFromLeftToRightAsTheMapDoes) {
  PLUVIA_NEEDS_OPENGL();
  Image map = make_image(64, 32, 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      map.at(x, y, 0) = static_cast<float>(x + 1);
      map.at(x, y, 1) = static_cast<float>(y + 1);
    }
  }
  Scene scene;
  scene.environment.map_file = testing::TempDir() + "pluvia_sky.exr";
  scene.environment.scale_cd_m2 = 2;
  write_exr(scene.environment.map_file, map);
  scene.camera.width_px = scene.camera.height_px = 9;
  scene.camera.vertical_fov_deg = 1;
  for (const auto& [x, y] : {std::pair{10, 5}, {32, 16}, {50, 28}, {3, 15}}) {
    const double azimuth = 2 * std::numbers::pi * ((x + 0.5) / 64 - 0.5);
    const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / 32);
    scene.camera.target_m =
        scene.camera.position_m + Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                  -std::cos(elevation) * std::sin(azimuth),
                                                  std::sin(elevation));
    const Frame frame = RainRenderer(scene, {}).render(0);
    // Bilinear in a linear map is exact; the driver's atan errs by 3e-6 rad = 3e-5 texels, and four
    // samples lie around the direction.
    EXPECT_NEAR(frame.background.at(4, 4, 0), 2 * (x + 1), 2e-3) << x << ", " << y;
    EXPECT_NEAR(frame.background.at(4, 4, 1), 2 * (y + 1), 2e-3) << x << ", " << y;
  }
  std::filesystem::remove(scene.environment.map_file);
}

TEST(RainFrame, WithoutRainItIsTheBackgroundBitForBit) {
  PLUVIA_NEEDS_OPENGL();
  const Frame dry = RainRenderer(rainy_scene(0), {}).render(0);
  EXPECT_EQ(dry.color.values, dry.background.values);
  EXPECT_EQ(dry.streaks_in_view, 0);
  const Frame wet = RainRenderer(rainy_scene(2000), shared_atlas()).render(0);
  EXPECT_EQ(wet.background.values, dry.background.values);
  EXPECT_NE(wet.color.values, wet.background.values);
}

TEST(RainFrame, RainDimsTheBackgroundAndAddsItsLight) {
  PLUVIA_NEEDS_OPENGL();
  const Frame frame = RainRenderer(rainy_scene(20000), shared_atlas()).render(0.25);
  long wet = 0;
  for (int y = 0; y < frame.color.height; ++y) {
    for (int x = 0; x < frame.color.width; ++x) {
      const float tau = frame.rain_tau.at(x, y);
      wet += tau > 0;
      for (int c = 0; c < 3; ++c) {
        const float expected =
            std::exp(-tau) * frame.background.at(x, y, c) + frame.rain.at(x, y, c);
        EXPECT_NEAR(frame.color.at(x, y, c), expected, 3e-6f * expected);  // exp errs by 1e-6
        // A column's light may lie a little beside its coverage (realtime/cumulative_atlas.h).
        if (tau == 0 && frame.rain.at(x, y, c) == 0) {
          EXPECT_EQ(frame.color.at(x, y, c), frame.background.at(x, y, c));
        }
      }
    }
  }
  EXPECT_GT(wet, 1000);
}

void expect_finite(const Scene& scene, const char* name) {
  const Frame frame = RainRenderer(scene, shared_atlas()).render(0.1);
  EXPECT_TRUE(all_finite(frame.color) && all_finite(frame.rain) && all_finite(frame.rain_tau) &&
              all_finite(frame.background))
      << name;
}

TEST(RainFrame, NoNumberIsLostInOddScenes) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  expect_finite(scene, "no drops");
  scene = rainy_scene(3000);
  scene.lights.clear();
  expect_finite(scene, "no lamps");
  scene.environment = {};
  expect_finite(scene, "no light at all");
  scene = rainy_scene(3000);
  scene.mesh = {};
  expect_finite(scene, "no surface");
  scene.camera.target_m = scene.camera.position_m + Eigen::Vector3d(0, 0, 1);
  expect_finite(scene, "up the fall");
  scene.camera.target_m = scene.camera.position_m - Eigen::Vector3d(0, 0, 1);
  expect_finite(scene, "down the fall");
  scene.camera.width_px = scene.camera.height_px = 1;
  expect_finite(scene, "one pixel");
  scene = rainy_scene(3000);
  scene.camera.vertical_fov_deg = 150;
  expect_finite(scene, "150 degrees");
}

TEST(RainFrame, SceneAndAtlasMustAgree) {
  PLUVIA_NEEDS_OPENGL();
  const auto refusal = [](const Scene& scene, const RenderOptions& options = {}) {
    return message_of([&] { RainRenderer(scene, shared_atlas(), options); });
  };
  Scene scene = rainy_scene(100);
  scene.camera.exposure_s = 1e-4;
  EXPECT_EQ(refusal(scene),
            "scene: camera.exposure_s = 0.0001 s; expected 0.00038 s or more, in which a drop of "
            "3.2 mm falls its own diameter: less shows drops, not streaks");
  EXPECT_EQ(refusal(rainy_scene(100), {.finest_level = 5}), "finest_level = 5; expected 0 .. 4");
  EXPECT_EQ(refusal(rainy_scene(100), {.max_texel_px = 0}),
            "max_texel_px = 0; expected a number > 0");
  scene = rainy_scene(100);
  scene.lights.resize(513);
  EXPECT_EQ(refusal(scene), "scene: 513 lights; expected at most 512 with rain");
  EXPECT_EQ(refusal(rainy_scene(100), {.packets = {.most_drops = 0.5}}),
            "packets of 0.5 drops; expected 1 or more");
}

TEST(RainFrame, ATableThrowsItsShadowOnTheGroundAndOnNothingElse) {
  PLUVIA_NEEDS_OPENGL();
  for (const LightKind kind : {LightKind::point, LightKind::spot, LightKind::sun}) {
    Scene scene;
    scene.camera.width_px = 200;
    scene.camera.height_px = 200;
    scene.camera.position_m = {0, 0, 12};
    scene.camera.target_m = {0, 0, 0};
    scene.camera.vertical_fov_deg = 60;
    add_ground(scene.mesh, 0);
    add_rectangle(scene.mesh, {-1, -1, 2}, {2, 0, 0}, {0, 2, 0}, {.base_color = {0.5, 0.5, 0.5}});
    Light light{"light", {0.5, 0, 6}, {900, 900, 900}, kind};
    light.illuminance_lux = {9, 9, 9};
    light.direction = Eigen::Vector3d(-0.3, 0, -1).normalized();
    light.outer_half_angle_deg = 55;
    light.inner_half_angle_deg = 54;
    scene.lights = {light};
    const Image open = RainRenderer(scene, StreakAtlas{}).render(0).color;
    scene.lights[0].shadow = true;
    const Image shaded = RainRenderer(scene, StreakAtlas{}).render(0).color;
    const double focal = camera_frame(scene.camera).focal_px;
    int dark = 0, bright = 0;
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) {
        // Looking down, north up: the table is seen at height 2, the ground at 0.
        const Eigen::Vector2d ray((x + 0.5 - 100) / focal, (100 - y - 0.5) / focal);
        const Eigen::Vector2d table = 10 * ray, ground = 12 * ray;
        const double edge = std::max(std::abs(table.x()), std::abs(table.y())) - 1;
        if (std::abs(edge) < 0.15) continue;
        if (edge < 0) {
          EXPECT_EQ(shaded.at(x, y), open.at(x, y)) << "table " << x << ", " << y;
          continue;
        }
        const Eigen::Vector2d through =
            kind == LightKind::sun
                ? Eigen::Vector2d(ground - 2 * light.direction.head<2>() / -light.direction.z())
                : Eigen::Vector2d(ground + (light.position_m.head<2>() - ground) / 3);
        const double shadow = std::max(std::abs(through.x()), std::abs(through.y())) - 1;
        if (std::abs(shadow) < 0.1) continue;
        if (shadow < 0) {
          EXPECT_EQ(shaded.at(x, y), 0) << x << ", " << y;
          ++dark;
        } else {
          EXPECT_EQ(shaded.at(x, y), open.at(x, y)) << "ground " << x << ", " << y;
          ++bright;
        }
      }
    }
    EXPECT_GT(dark, 40);  // the table hides most of its shadow
    EXPECT_GT(bright, 10000);
  }
}

TEST(RainFrame, ADropInsideALampIsNotDrawnAndOneBesideItIsLitWithoutBound) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.drops = {{.centre_m = {0.5, 3, 2}}};
  const Eigen::Vector3d middle(0.5, 3, 2 - 8.49 / 120);
  scene.lights.resize(1);
  for (const double off_m : {0.0, 1e-3, 1.59e-3, 1.7e-3, 0.01}) {
    scene.lights[0].position_m = middle + Eigen::Vector3d(0, 0, off_m);
    const Frame frame = RainRenderer(scene, shared_atlas()).render(0);
    EXPECT_EQ(frame.streaks_in_view, off_m < 1.6e-3 ? 0 : 1) << off_m;
    EXPECT_TRUE(all_finite(frame.color)) << off_m;
  }
  scene.lights[0].radius_m = 0.05;
  EXPECT_EQ(RainRenderer(scene, shared_atlas()).render(0).streaks_in_view, 0);
}

TEST(RainFrame, LevelsThatNoDropCanNeedAreNotUploaded) {
  PLUVIA_NEEDS_OPENGL();
  const Scene near = rainy_scene(1000);
  Scene far = near;
  far.camera.position_m.y() -= 50;
  far.camera.target_m.y() -= 50;
  EXPECT_LT(3 * RainRenderer(far, shared_atlas()).atlas_bytes(),
            RainRenderer(near, shared_atlas()).atlas_bytes());
}

TEST(Shader, ErrorsNameTheFileAndLineThatHoldThem) {
  PLUVIA_NEEDS_OPENGL();
  const GlContext context;
  const ShaderFiles files = {
      {"bad.frag", "#version 450 core\n#include \"part.glsl\"\nvoid main() { part(); }\n"},
      {"part.glsl", "void part() {\n  missing = 1;\n}\n"},
      {"late.frag", "#version 450 core\n#include \"good.glsl\"\nvoid main() { nothing; }\n"},
      {"good.glsl", "const int good = GIVEN;\n"},
      {"lost.frag", "#version 450 core\n\n#include \"nowhere.glsl\"\n"},
      {"chosen.frag", "#version 450 core\n#include CHOICE\nvoid main() { part(); }\n"}};
  const auto refusal = [&](const char* name) {
    return message_of([&] {
      compile_shader(GL_FRAGMENT_SHADER, flatten_shader(name, {{"GIVEN", "1"}}, files));
    });
  };
  EXPECT_TRUE(refusal("bad.frag").starts_with("realtime/shaders/part.glsl:2: "))
      << refusal("bad.frag");
  EXPECT_TRUE(refusal("late.frag").starts_with("realtime/shaders/late.frag:3: "))
      << refusal("late.frag");
  EXPECT_EQ(refusal("lost.frag"),
            "realtime/shaders/lost.frag:3: there is no shader \"nowhere.glsl\"; expected a file of "
            "realtime/shaders/");
  // An include may name a define that names the file.
  EXPECT_NE(flatten_shader("chosen.frag", {{"CHOICE", "good.glsl"}}, files).text.find("int good"),
            std::string::npos);
  EXPECT_EQ(refusal("chosen.frag"),
            "realtime/shaders/chosen.frag:2: there is no shader \"CHOICE\"; expected a file of "
            "realtime/shaders/");
}

TEST(Video, FramesBecomeAnMp4AndAFolderThatIsNotThereIsRefused) {
  if (!ffmpeg_is_present()) GTEST_SKIP() << "no ffmpeg on the PATH";
  const std::string file = testing::TempDir() + "pluvia_video.mp4";
  Image frame = make_image(64, 48, 3);
  VideoWriter writer(file, 64, 48, 30);
  for (int i = 0; i < 10; ++i) {
    for (float& value : frame.values) value = 0.1f * static_cast<float>(i);
    writer.add(frame, 1);
  }
  writer.finish();
  EXPECT_EQ(read_file(file).substr(4, 4), "ftyp");
  std::filesystem::remove(file);

  const std::string message = message_of([&] {
    VideoWriter lost("/nowhere/at/all.mp4", 64, 48, 30);
    for (int i = 0; i < 100; ++i) lost.add(frame, 1);
    lost.finish();
  });
  EXPECT_TRUE(message.starts_with("/nowhere/at/all.mp4: ffmpeg: ")) << message;
  EXPECT_NE(message.find("No such file or directory"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_EQ(message_of([] { VideoWriter("odd.mp4", 63, 48, 30); }),
            "odd.mp4: 63 x 48 px at 30 frames/s; expected an even width and height and at least 1 "
            "frame/s");
}

}  // namespace
}  // namespace pluvia
