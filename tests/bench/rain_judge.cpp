// What the ways of drawing thin streaks cost and how far they are from the exact composite of the
// same drops (validate/frame_composite.h): costs are medians of frames of one run on one machine,
// so that rows may be compared with each other and with nothing else.
//   rain_judge ATLAS [--drops 10000] [--lights 1] [--scale 1] [--frames 5]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "raytrace/drop_field.h"
#include "realtime/rain_renderer.h"
#include "tests/bench/far_rain.h"
#include "validate/frame_composite.h"

namespace pluvia {
namespace {

struct JudgeFlags {
  std::string atlas = {};
  double drops = 1e4, scale = 1;
  int lights = 1, frames = 5;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Of the rain alone.
double relative_rmse(const Frame& frame, const FrameComposite& truth) {
  double square = 0, all = 0;
  for (std::size_t i = 0; i < frame.color.values.size(); ++i) {
    const double rain = static_cast<double>(frame.color.values[i]) -
                        static_cast<double>(frame.background.values[i]);
    square += std::pow(rain - static_cast<double>(truth.rain.values[i]), 2);
    all += std::pow(static_cast<double>(truth.rain.values[i]), 2);
  }
  return std::sqrt(square / all);
}

void run(const JudgeFlags& flags) {
  const StreakAtlas atlas = read_atlas(flags.atlas);
  const Scene scene = far_rain(flags.drops, flags.lights, flags.scale);
  constexpr double time_s = 0.5;
  const auto drops =
      drop_field(scene, make_rain_space(scene), static_cast<int>(atlas.layers.size()), time_s);
  FrameComposite truth;
  fmt::print(
      "| widest splat px | streaks | error | rain ms | CPU us a streak |\n|---|---|---|---|---|\n");
  for (const double widest_px : {0.0, 0.5, 1.0, 2.0, 4.0}) {
    RainRenderer renderer(scene, atlas, {.widest_splat_px = widest_px});
    Frame frame = renderer.render(time_s);
    if (truth.color.values.empty())
      truth = composite_frame(scene, atlas, drops, scene.environment.uniform_cd_m2,
                              frame.background, frame.depth_m);
    std::vector<double> wall, cpu;
    for (int k = 0; k < flags.frames; ++k) {
      frame = renderer.render(time_s);
      for (const PassCost& pass : frame.costs) {
        if (pass.pass != "rain") continue;
        wall.push_back(pass.wall_s);
        cpu.push_back(pass.cpu_s);
      }
    }
    fmt::print("| {} | {} | {:.4f} | {:.1f} | {:.2f} |\n", widest_px, frame.streaks_in_view,
               relative_rmse(frame, truth), 1e3 * median(wall),
               1e6 * median(cpu) / static_cast<double>(std::max(1L, frame.streaks_in_view)));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("Ways of drawing thin streaks: cost and error", "rain_judge");
  pluvia::JudgeFlags flags;
  app.add_option("atlas", flags.atlas, "folder of an atlas")->required();
  app.add_option("--drops", flags.drops, "1e3 .. 1e6")->check(CLI::Range(1e3, 1e6));
  app.add_option("--lights", flags.lights, "0 .. 6")->check(CLI::Range(0, 6));
  app.add_option("--scale", flags.scale, "1: drops 12 to 40 m away")->check(CLI::Range(0.05, 10.0));
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
