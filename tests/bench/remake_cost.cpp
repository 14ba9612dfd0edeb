// What a viewer's frame costs beside its passes: making the renderer, making it anew for the same
// scene, and the way through the CPU that a window does without. Medians of one run.
//   remake_cost SCENE --atlas DIR [--runs 5]
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "realtime/show_pass.h"
#include "realtime/viewer/scene_edits.h"
#include "validate/median.h"

namespace pluvia {
namespace {

double median_ms(int runs, const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  return median(times);
}

void measure(const std::string& file, const std::string& atlas_folder, int runs) {
  Scene scene = read_scene(file);
  scene.camera.width_px = 1280;
  scene.camera.height_px = 720;
  scene.camera_path = look_around(scene.camera);
  const StreakAtlas atlas = read_atlas(atlas_folder);
  const auto context = std::make_shared<GlContext>();
  const double make = median_ms(runs, [&] { RainRenderer(context, scene, atlas); });
  RainRenderer renderer(context, scene, atlas);
  const double remake = median_ms(runs, [&] {
    renderer.remake(scene, atlas, {});
    glFinish();
  });
  Frame frame = renderer.draw(1);
  const double read = median_ms(runs, [&] { renderer.read(frame); });
  const ShowPass show = make_show_pass();
  const GlTexture target = make_texture(GL_RGBA8, 1280, 720);
  const GlFramebuffer framebuffer = make_framebuffer({target.id()}, 0);
  const double shown = median_ms(runs, [&] {
    show_picture(show, renderer.picture(), 1, framebuffer.id(), 1280, 720);
    glFinish();
  });
  fmt::print("{}: made {:.0f} ms, made anew {:.0f} ms, read {:.0f} ms, shown {:.0f} ms\n", file,
             make, remake, read, shown);
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("What a viewer's frame costs beside its passes", "remake_cost");
  std::string scene, atlas;
  int runs = 5;
  app.add_option("scene", scene, "scene, TOML")->required();
  app.add_option("--atlas", atlas, "folder of the atlas")->required();
  app.add_option("--runs", runs, "of each")->check(CLI::Range(1, 1000))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    pluvia::measure(scene, atlas, runs);
  } catch (const std::exception& error) {
    fmt::print(stderr, "remake_cost: {}\n", error.what());
    return 1;
  }
  return 0;
}
