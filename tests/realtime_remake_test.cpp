// A renderer that lives on while its scene is edited: what it keeps, and that its pictures are
// those of a new one.
#include <gtest/gtest.h>

#include "atlas/image_io.h"
#include "realtime/gpu_atlas.h"
#include "realtime/rain_renderer.h"
#include "realtime/show_pass.h"
#include "tests/realtime_fixture.h"
#include "tests/synthetic_atlas.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

void expect_equal(const Frame& found, const Frame& expected) {
  EXPECT_EQ(found.color.values, expected.color.values);
  EXPECT_EQ(found.background.values, expected.background.values);
  EXPECT_EQ(found.rain.values, expected.rain.values);
  EXPECT_EQ(found.depth_m.values, expected.depth_m.values);
  EXPECT_EQ(found.streaks_in_view, expected.streaks_in_view);
}

TEST(Remake, DrawingLeavesThePicturesOnTheGpuUntilTheyAreRead) {
  PLUVIA_NEEDS_OPENGL();
  RainRenderer renderer(rainy_scene(2000), quarter_atlas());
  const Frame expected = renderer.render(0.25);
  Frame frame = renderer.draw(0.25);
  EXPECT_TRUE(frame.color.values.empty());
  EXPECT_EQ(frame.costs.size(), expected.costs.size());
  renderer.read(frame);
  expect_equal(frame, expected);
}

TEST(Remake, AnEditedSceneIsDrawnAsByANewRenderer) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(500);
  RainRenderer renderer(scene, quarter_atlas());
  const Frame before = renderer.render(0.5);
  Scene wet = rainy_scene(4000), dry = rainy_scene(0), large = scene, foggy = scene;
  large.camera.width_px = 200;
  large.camera.height_px = 90;
  foggy.fog = Fog{.extinction_per_m = 0.02};
  for (const Scene& edited : {wet, dry, large, foggy, scene}) {
    renderer.remake(edited, quarter_atlas(), {});
    expect_equal(renderer.render(0.5), RainRenderer(edited, quarter_atlas()).render(0.5));
  }
  renderer.remake(scene, quarter_atlas(), {.lookup = LookupMode::trilinear});
  EXPECT_NE(renderer.render(0.5).color.values, before.color.values);
}

TEST(Remake, ASceneThatIsRefusedLeavesTheRendererAsItWas) {
  PLUVIA_NEEDS_OPENGL();
  const Scene scene = rainy_scene(500);
  RainRenderer renderer(scene, quarter_atlas());
  const Frame before = renderer.render(0.5);
  Scene short_shutter = scene;
  short_shutter.camera.exposure_s = 1e-5;
  EXPECT_THROW(renderer.remake(short_shutter, quarter_atlas(), {}), std::runtime_error);
  expect_equal(renderer.render(0.5), before);
}

TEST(Remake, ACameraAndLampsMoveWithoutIt) {
  PLUVIA_NEEDS_OPENGL();
  Scene scene = rainy_scene(2000);
  scene.fog = Fog{.extinction_per_m = 0.02};
  scene.glow = Glow{};
  // A path asks for what any camera may need; its end is the camera that is looked through below.
  scene.camera_path = {{0, scene.camera.position_m, scene.camera.target_m},
                       {1, {-1, 2, 1.2}, {-2, 8, 2}}};
  RainRenderer renderer(scene, quarter_atlas());
  Scene moved = scene;
  moved.lights[0].position_m = {-2, 6, 4};
  moved.lights[1].intensity_cd = {10, 900, 20};
  const Frame expected = RainRenderer(moved, quarter_atlas()).render(1);
  EXPECT_NE(renderer.render(1).color.values, expected.color.values);
  renderer.set_lights(moved.lights);
  renderer.look_through(camera_at(scene, 1));
  expect_equal(renderer.render(1), expected);
}

TEST(Remake, OfTheAtlasWhatIsThereStays) {
  PLUVIA_NEEDS_OPENGL();
  const GlContext context;
  const auto fine = upload_sums(quarter_atlas(), {.finest = 0, .coarsest = 2}, true, nullptr);
  EXPECT_EQ(upload_sums(quarter_atlas(), {.finest = 1, .coarsest = 2}, false, fine), fine);
  EXPECT_EQ(upload_sums(quarter_atlas(), {.finest = 0, .coarsest = 1}, true, fine), fine);
  EXPECT_NE(upload_sums(quarter_atlas(), {.finest = 0, .coarsest = 3}, true, fine), fine);
  const auto coarse = upload_sums(quarter_atlas(), {.finest = 1, .coarsest = 2}, false, nullptr);
  EXPECT_LT(coarse->bytes, fine->bytes);
  EXPECT_NE(upload_sums(quarter_atlas(), {.finest = 0, .coarsest = 2}, false, coarse), coarse);
  EXPECT_NE(upload_sums(quarter_atlas(), {.finest = 1, .coarsest = 2}, true, coarse), coarse);
}

TEST(Remake, OfTheProfilesOfThinStreaksToo) {
  PLUVIA_NEEDS_OPENGL();
  const GlContext context;
  const auto all = upload_profiles(quarter_atlas(), 1, true, nullptr);
  EXPECT_EQ(upload_profiles(quarter_atlas(), 1, false, all), all);
  EXPECT_NE(upload_profiles(quarter_atlas(), 2, true, all), all);
  const auto lamps = upload_profiles(quarter_atlas(), 1, false, nullptr);
  EXPECT_NE(upload_profiles(quarter_atlas(), 1, true, lamps), lamps);
}

TEST(Remake, SeveralRenderersShareAContextThatTheyDoNotOwn) {
  PLUVIA_NEEDS_OPENGL();
  GlContext owner;
  const auto shared = std::make_shared<GlContext>([&owner] { owner.make_current(); });
  const Scene scene = rainy_scene(500);
  Frame first;
  {
    RainRenderer renderer(shared, scene, quarter_atlas());
    first = renderer.render(0.5);
  }
  RainRenderer renderer(shared, scene, quarter_atlas());
  expect_equal(renderer.render(0.5), first);
  expect_equal(RainRenderer(scene, quarter_atlas()).render(0.5), first);
}

// The target's pixels, top row first.
std::vector<unsigned char> shown_bytes(const RainRenderer& renderer, double white, int width,
                                       int height) {
  const GlTexture target = make_texture(GL_RGBA8, width, height);
  const GlFramebuffer framebuffer = make_framebuffer({target.id()}, 0);
  show_picture(make_show_pass(), renderer.picture(), white, framebuffer.id(), width, height);
  const auto row = static_cast<std::size_t>(3 * width);
  std::vector<unsigned char> below(row * static_cast<std::size_t>(height)), bytes;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(target.id(), 0, GL_RGB, GL_UNSIGNED_BYTE, static_cast<GLsizei>(below.size()),
                    below.data());
  for (std::size_t y = static_cast<std::size_t>(height); y-- > 0;)
    bytes.insert(bytes.end(), below.begin() + static_cast<std::ptrdiff_t>(y * row),
                 below.begin() + static_cast<std::ptrdiff_t>((y + 1) * row));
  return bytes;
}

TEST(ShowPass, ShowsWhatThePngOfTheFrameShows) {
  PLUVIA_NEEDS_OPENGL();
  RainRenderer renderer(rainy_scene(2000), quarter_atlas());
  const Frame frame = renderer.render(0.5);
  const TemporaryFolder folder;
  write_png(folder / "frame.png", frame.color, 2.5);
  const Image png = read_image(folder / "frame.png");
  const std::vector<unsigned char> bytes = shown_bytes(renderer, 2.5, 160, 120);
  ASSERT_EQ(bytes.size(), png.values.size());
  // Float instead of double may round one value in a step the other way.
  for (std::size_t i = 0; i < bytes.size(); ++i)
    ASSERT_NEAR(static_cast<double>(bytes[i]), 255 * static_cast<double>(png.values[i]), 1.01) << i;
}

TEST(ShowPass, AWindowOfAnotherSizeShowsAllOfThePicture) {
  PLUVIA_NEEDS_OPENGL();
  RainRenderer renderer(rainy_scene(2000), quarter_atlas());
  renderer.draw(0.5);
  const std::vector<unsigned char> same = shown_bytes(renderer, 2.5, 160, 120);
  const std::vector<unsigned char> twice = shown_bytes(renderer, 2.5, 320, 240);
  for (std::size_t y = 0; y < 240; ++y) {
    for (std::size_t x = 0; x < 320; ++x)
      ASSERT_EQ(twice[3 * (320 * y + x) + 1], same[3 * (160 * (y / 2) + x / 2) + 1])
          << x << ' ' << y;
  }
}

}  // namespace
}  // namespace pluvia
