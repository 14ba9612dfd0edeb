// What the ways of drawing thin streaks cost and how far they are from the exact composite of the
// same drops (validate/frame_composite.h): costs are medians of frames of one run on one machine,
// so that rows may be compared with each other and with nothing else.
//   rain_judge [ATLAS] [--drops 10000] [--lights 1] [--scale 1] [--frames 5]
//   [--most-samples 6] [--against-walk] [--only TEXT]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "tests/bench/far_rain.h"
#include "tests/synthetic_atlas.h"
#include "validate/flip.h"
#include "validate/frame_composite.h"
#include "validate/median.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

struct JudgeFlags {
  std::string atlas = {}, only = {};
  double drops = 1e4, scale = 1;
  int lights = 1, frames = 5, most_samples = 6;
  bool against_walk = false;
};

// The frame, and the frame minus the frame without rain; of `samples` x `samples` pixels the mean.
struct Picture {
  Image color = {}, rain = {};
};

Picture picture_of(const Frame& frame, int samples) {
  const int width = frame.color.width / samples, height = frame.color.height / samples;
  Picture picture = {make_image(width, height, 3), make_image(width, height, 3)};
  const float share = 1.0F / static_cast<float>(samples * samples);
  for (int y = 0; y < samples * height; ++y) {
    for (int x = 0; x < samples * width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float color = frame.color.at(x, y, c);
        picture.color.at(x / samples, y / samples, c) += share * color;
        picture.rain.at(x / samples, y / samples, c) +=
            share * (color - frame.background.at(x, y, c));
      }
    }
  }
  return picture;
}

// As a PNG shows it: white is 1, what is brighter is white.
double mean_flip(const Image& truth, const Image& color, double white_cd_m2) {
  const auto shown = [&](Image image) {
    for (float& value : image.values)
      value = std::clamp(value / static_cast<float>(white_cd_m2), 0.0F, 1.0F);
    return image;
  };
  return ldr_flip(shown(truth), shown(color)).mean;
}

struct Path {
  std::string name = {};
  RenderOptions options = {};
  int supersampling = 1;  // samples along each side of a pixel
};

struct Cost {
  double wall_s = 0, cpu_s = 0;
};

// Of the rain in one frame.
Cost rain_cost(const Frame& frame) {
  Cost cost;
  for (const PassCost& pass : frame.costs) {
    if (pass.pass != "rain" && pass.pass != "billboards") continue;
    cost.wall_s += pass.wall_s;
    cost.cpu_s += pass.cpu_s;
  }
  return cost;
}

void run(const JudgeFlags& flags) {
  const StreakAtlas atlas =
      flags.atlas.empty() ? synthetic_atlas({.cell_width_px = 32, .levels = 6, .path_rows = 1400})
                          : read_atlas(flags.atlas);
  const Scene scene = far_rain(flags.drops, flags.lights, flags.scale);
  constexpr double time_s = 0.5;
  const std::vector<Drop> drops = drops_with_sets(scene, set_numbers(atlas), time_s);
  const RenderOptions billboards = {.path = RainPath::billboards_2010,
                                    .packets = {.selection = PacketSelection::rectangle}};
  const std::vector<Path> paths = {{"billboards of 2010", billboards},
                                   {"the same, 2 x 2 samples a pixel", billboards, 2},
                                   {"the same, 4 x 4", billboards, 4},
                                   {"the same, 6 x 6", billboards, 6},
                                   {"quads", {.widest_splat_px = 0}},
                                   {"splat up to 1 px", {.widest_splat_px = 1}},
                                   {"splat up to 3 px", {.widest_splat_px = 3}},
                                   {"far streaks 64", {.far_streaks = 64}},
                                   {"far streaks 16", {.far_streaks = 16}},
                                   {"far streaks 4", {.far_streaks = 4}},
                                   {"far streaks 1", {.far_streaks = 1}}};
  const Frame dry = RainRenderer(scene, atlas, {.widest_splat_px = 0}).render(time_s);
  Picture truth = {};
  if (flags.against_walk) {
    truth = picture_of(RainRenderer(scene, atlas).render(time_s), 1);
  } else {
    FrameComposite exact =
        composite_frame(scene, atlas, drops, sky_of(scene, atlas, 0), dry.background, dry.depth_m);
    truth = {std::move(exact.color), std::move(exact.rain)};
  }
  fmt::print("{} streaks in view; {}\n\n", dry.streaks_in_view,
             RainRenderer(scene, atlas).gl_info().renderer);
  fmt::print("| path | FLIP | relative RMSE | rain ms | CPU ms |\n|---|---|---|---|---|\n");
  for (const Path& path : paths) {
    if (path.supersampling > flags.most_samples) continue;
    if (path.name.find(flags.only) == std::string::npos) continue;
    Scene sampled = scene;
    sampled.camera.width_px *= path.supersampling;
    sampled.camera.height_px *= path.supersampling;
    RainRenderer renderer(sampled, atlas, path.options);
    Frame frame = renderer.render(time_s);  // compiles, and makes the records' room
    std::vector<double> wall, cpu;
    for (int k = 0; k < flags.frames; ++k) {
      const Cost cost = rain_cost(renderer.render(time_s));
      wall.push_back(cost.wall_s);
      cpu.push_back(cost.cpu_s);
    }
    const Picture picture = picture_of(frame, path.supersampling);
    const double flip = mean_flip(truth.color, picture.color, scene.camera.white_cd_m2);
    const double error = relative_rmse(picture.rain, truth.rain);
    fmt::print("| {} | {:.5f} | {:.4f} | {:.2f} | {:.2f} |\n", path.name, flip, error,
               1e3 * median(wall), 1e3 * median(cpu));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("Ways of drawing thin streaks: cost and error", "rain_judge");
  pluvia::JudgeFlags flags;
  app.add_option("atlas", flags.atlas, "folder of an atlas; a made-up one if none is given");
  app.add_option("--drops", flags.drops, "1e3 .. 1e6")->check(CLI::Range(1e3, 1e6));
  app.add_option("--lights", flags.lights, "0 .. 6")->check(CLI::Range(0, 6));
  app.add_option("--scale", flags.scale, "1: drops 12 to 40 m away")->check(CLI::Range(0.05, 10.0));
  app.add_option("--most-samples", flags.most_samples, "of the billboards, along a pixel's side")
      ->check(CLI::Range(1, 6));
  app.add_option("--only", flags.only, "rows with this in their name");
  app.add_flag("--against-walk", flags.against_walk,
               "the judge is the walk of every drop, in seconds");
  app.add_option("--frames", flags.frames, "of which the median is taken")
      ->check(CLI::Range(1, 99));
  CLI11_PARSE(app, argc, argv);
  try {
    pluvia::run(flags);
  } catch (const std::exception& error) {
    fmt::print(stderr, "rain_judge: {}\n", error.what());
    return 1;
  }
  return 0;
}
