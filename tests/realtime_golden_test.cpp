// A small picture of each effect, for somebody to look at when it changes: tests/golden/NAME.exr,
// half float. What is found is written to pluvia_golden_NAME.exr in the folder of temporary files,
// and from there all are made anew:
//
//   TEST_TMPDIR=DIR/ build/realtime_golden_test
//   for name in fog glow lens refraction shadows sky spheres streaks_quads streaks_thin; do
//     oiiotool --nosoftwareattrib DIR/pluvia_golden_$name.exr -d half -o tests/golden/$name.exr
//   done
//
// (the splash: tests/realtime_splash_test.cpp). A picture is made such that another processor or
// driver may change it by roundings alone: no edge of a surface is in it, where a rounded vertex
// decides about a pixel. Half floats err by 2^-11 = 5e-4 of a value at most, by 2e-4 in the mean
// square.
#include <cmath>

#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "raytrace/mask_set.h"
#include "realtime/rain_renderer.h"
#include "tests/evening_sky.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

void expect_numbers(const Frame& frame) {
  for (const Image* image : {&frame.color, &frame.background, &frame.rain, &frame.rain_tau})
    EXPECT_TRUE(all_finite(*image));
  for (const float depth_m : frame.depth_m.values) ASSERT_GT(depth_m, 0);  // sky: infinity
}

// bound: of the root of the mean square, relative to the golden's.
void expect_golden(const char* name, const Image& found, double bound) {
  const std::string file = testing::TempDir() + "pluvia_golden_" + name + ".exr";
  write_exr(file, found);
  const Image golden = read_image(std::string(PLUVIA_SOURCE_DIR "/tests/golden/") + name + ".exr");
  ASSERT_EQ(found.width, golden.width);
  ASSERT_EQ(found.values.size(), golden.values.size());
  double off = 0, all = 0;
  for (std::size_t i = 0; i < found.values.size(); ++i) {
    off += std::pow(static_cast<double>(found.values[i] - golden.values[i]), 2);
    all += std::pow(static_cast<double>(golden.values[i]), 2);
  }
  EXPECT_GT(all, 0) << name;
  EXPECT_LT(std::sqrt(off / all), bound) << file;
}

// A hundred drops before two lamps and a grey sky, without a surface.
Scene shower() {
  Scene scene = rainy_scene(0);
  scene.mesh = {};
  scene.camera.width_px = 96;
  scene.camera.height_px = 72;
  for (Light& light : scene.lights) light.intensity_cd *= 0.05;
  scene.rain.sizes = {{.drops_per_m3 = 2, .velocity_m_s = {2, 0, -8}}};
  scene.rain.box_min_m = {-1, 1, 0};
  scene.rain.box_max_m = {3, 6, 5};
  return scene;
}

// Places in float: 1e-3 of a pixel, also far from the picture's middle, over which a streak one
// pixel wide changes by twice that; and half floats.
constexpr double streak_bound = 3e-3;

TEST(Golden, StreaksAsQuads) {
  PLUVIA_NEEDS_OPENGL();
  const Frame frame = RainRenderer(shower(), quarter_atlas(), {.widest_splat_px = 0}).render(0.5);
  expect_numbers(frame);
  expect_golden("streaks_quads", frame.rain, streak_bound);
}

TEST(Golden, ThinStreaks) {
  PLUVIA_NEEDS_OPENGL();
  RainRenderer renderer(shower(), quarter_atlas(), {.widest_splat_px = 16});
  EXPECT_EQ(renderer.streak_records(0.5).streaks.size(), 0u) << "all of them are thin";
  const Frame frame = renderer.render(0.5);
  expect_numbers(frame);
  expect_golden("streaks_thin", frame.rain, streak_bound);
}

TEST(Golden, StreaksOutOfFocus) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = shower();
  scene.camera.depth_of_field = DepthOfField{.aperture_m = 0.1, .focus_m = 4};
  const Frame frame = RainRenderer(scene, quarter_atlas()).render(0.5);
  expect_numbers(frame);
  expect_golden("lens", frame.rain, streak_bound);
}

TEST(Golden, StreaksUnderASky) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = shower();
  scene.lights.clear();  // nothing else shines
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(scene.environment.map_file, evening_map());
  RainRenderer renderer(scene, sky_atlas(), {.widest_splat_px = 0.1});
  const Frame frame = renderer.render(0.5);
  const auto quads = static_cast<long>(renderer.streak_records(0.5).streaks.size());
  EXPECT_GT(quads, frame.streaks_in_view / 4);  // and the others are thin
  EXPECT_LT(quads, frame.streaks_in_view * 3 / 4);
  expect_numbers(frame);
  expect_golden("sky", frame.rain, streak_bound);
}

// As published in 2006: some as quads, some thin.
TEST(Golden, StreaksThatShineAsSpheres) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = shower();
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(scene.environment.map_file, evening_map());
  RainRenderer renderer(scene, quarter_atlas(),
                        {.widest_splat_px = 0.1, .look = StreakLook::sphere_published});
  const Frame frame = renderer.render(0.5);
  const auto quads = static_cast<long>(renderer.streak_records(0.5).streaks.size());
  EXPECT_GT(quads, frame.streaks_in_view / 4);
  EXPECT_LT(quads, frame.streaks_in_view * 3 / 4);
  expect_numbers(frame);
  expect_golden("spheres", frame.rain, streak_bound);
}

// Some as quads, some thin, of masks that are traced here.
TEST(Golden, StreaksThatRefract) {
  PLUVIA_NEEDS_OPENGL();
  const TemporaryFolder folder;
  Scene scene = shower();
  scene.environment = {.map_file = folder / "evening.exr", .scale_cd_m2 = 10};
  write_exr(scene.environment.map_file, evening_map());
  StreakAtlas atlas = quarter_atlas();
  MaskSetCost cost;
  atlas.masks = trace_mask_set(
      read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml"),
      {.size_px = 16, .phases = 3, .instants = 16, .view_elevations_deg = {0, 20}}, cost);
  RainRenderer renderer(scene, atlas,
                        {.widest_splat_px = 0.1, .look = StreakLook::refraction, .capture_px = 64});
  const Frame frame = renderer.render(0.5);
  expect_numbers(frame);
  expect_golden("refraction", frame.rain, streak_bound);
}

// A lamp above a table, whose shadow lies on the ground and on the drops below; the camera looks
// down from under the table, past it.
TEST(Golden, Shadows) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.camera.width_px = 96;
  scene.camera.height_px = 72;
  scene.camera.position_m = {0, -3, 1.9};
  scene.camera.target_m = {0, 0, 0};
  add_rectangle(scene.mesh, {-0.8f, -0.5f, 2}, {1.6f, 0, 0}, {0, 1, 0}, {});
  scene.lights = {{"lamp", {0.3, 0, 5}, {90, 70, 40}}};
  scene.lights[0].shadow = true;
  scene.environment.uniform_cd_m2 = {0.05, 0.06, 0.08};
  scene.rain.sizes = {{.drops_per_m3 = 4, .velocity_m_s = {8, 0, -4}}};  // also under the table
  scene.rain.box_min_m = {-2, -1.5, 0};
  scene.rain.box_max_m = {2, 1.5, 1.9};
  const Frame frame = RainRenderer(scene, quarter_atlas()).render(0.5);
  expect_numbers(frame);
  // The shadow's edge runs through 200 of 6912 pixels; the share of the lamp there has 8 bits
  // (bilinear filters of drivers): 1 / 256 of the light in a thirtieth of the pixels is less than
  // the half floats. Streaks as above.
  expect_golden("shadows", frame.color, streak_bound);
}

TEST(Golden, Fog) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(0);
  scene.camera.width_px = 64;
  scene.camera.height_px = 48;
  scene.camera.target_m = {1, 5, -0.6};
  scene.camera.vertical_fov_deg = 25;  // ground alone, up to 10 m away
  scene.rain.sizes = {{.drops_per_m3 = 1}};
  scene.rain.box_min_m = {-2, 2, 0};
  scene.rain.box_max_m = {4, 7, 3};
  scene.rain.undrawn_per_m = 0.02;
  for (Light& light : scene.lights) light.intensity_cd *= 0.1;
  scene.fog = Fog{.extinction_per_m = 0.15};
  const Frame frame = RainRenderer(scene, quarter_atlas()).render(0.5);
  expect_numbers(frame);
  // A driver may round a vertex to 1/256 of a pixel: of a row, 0.6 m at most of ground under 0.15
  // / m, 4e-4 in the veil; streaks as above, a tenth of the picture; and half floats.
  expect_golden("fog", frame.color, 1e-3);
}

TEST(Golden, Glow) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene;
  scene.camera.width_px = 64;
  scene.camera.height_px = 48;
  scene.camera.target_m = {0, 5, 2.5};
  Light spot{"spot", {3, 9, 5}, {10, 100, 20}, LightKind::spot};
  spot.direction = Eigen::Vector3d(-0.4, -0.2, -1).normalized();
  Light sun{.name = "sun", .kind = LightKind::sun};
  sun.direction = Eigen::Vector3d(-0.9, -0.2, -0.4).normalized();
  sun.illuminance_lux = {1, 2, 8};
  scene.lights = {{"lamp", {-1, 8, 4}, {40, 20, 5}}, spot, sun};
  scene.fog = Fog{.extinction_per_m = 0.03};
  scene.glow = Glow{};
  const Frame frame = RainRenderer(scene, StreakAtlas{}).render(0);
  expect_numbers(frame);
  // 16 samples of a ray, each a product of tan, atan and exp that drivers know to 1e-5; a sample on
  // a spot's rim is a sixteenth of its light in a few pixels. And half floats.
  expect_golden("glow", frame.color, 3e-3);
}

}  // namespace
}  // namespace pluvia
