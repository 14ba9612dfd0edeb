#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "atlas/image_io.h"
#include "raytrace/drop_field.h"
#include "raytrace/moving_parts.h"
#include "realtime/rain_renderer.h"
#include "validate/checks.h"
#include "validate/frame_composite.h"
#include "validate/metrics.h"

namespace pluvia {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

void add_frame_comparison(const Scene& scene, const Frame& frame, const FrameComposite& truth,
                          const std::string& what, Report& report) {
  const Image ours = rain_layer(frame.color, frame.background);
  Check check = deviation(
      "frame.composite", relative_rmse(ours, truth.rain), 0, 0.02, "relative RMSE",
      fmt::format("Rain-only signal (frame minus the frame without rain) of {}, {} "
                  "streaks in view: the real-time renderer against exact areas of every texel over "
                  "every pixel in double precision, drops composited in depth order, from the same "
                  "drops, database, background and depth. Both are deterministic: no uncertainty.",
                  what, frame.streaks_in_view));
  report.checks.push_back(check);

  const double white = scene.camera.white_cd_m2;
  report.comparisons.push_back(
      {.title = "A frame of rain",
       .text = "The scene with rain as the real-time renderer draws it, and without.",
       .unit = "cd/m^2",
       .picture = {.image = frame.color, .white = white, .caption = "with rain"},
       .reference = {.image = frame.background, .white = white, .caption = "without rain"},
       .gain = 4});
  report.comparisons.push_back(
      {.title = "The rain alone, against the exact composite of the same atlas",
       .text = "Frame minus background, four times as bright as above.",
       .unit = "cd/m^2",
       .picture = {.image = ours, .white = white / 4, .caption = "real-time"},
       .reference = {.image = truth.rain, .white = white / 4, .caption = "exact composite"},
       .gain = 16});
  const auto comparing = Clock::now();
  add_picture_checks("frame",
                     {.picture = frame.color,
                      .reference = truth.color,
                      .dry = frame.background,
                      .white = white,
                      .streaks = truth.streaks},
                     report);
  report.timings_s.emplace_back("picture metrics", seconds_since(comparing));
}

void add_frame_check(const std::string& scene_file, const std::string& atlas_folder, double time_s,
                     Report& report) {
  Scene scene = scene_at(read_scene(scene_file), time_s);
  scene.splashes.reset();  // the composite lays down streaks alone, behind a pinhole
  scene.camera.depth_of_field.reset();
  report.seeds.emplace_back("drops of the frame", std::to_string(scene.rain.seed));
  const StreakAtlas atlas = read_atlas(atlas_folder);
  RainRenderer renderer(scene, atlas);
  renderer.render(time_s);  // the first frame compiles and uploads
  const Frame frame = renderer.render(time_s);
  for (const PassCost& cost : frame.costs)
    report.timings_s.emplace_back("real-time frame: " + cost.pass, cost.wall_s);

  const auto start = Clock::now();
  const auto drops =
      drop_field(scene, make_rain_space(scene), static_cast<int>(atlas.layers.size()), time_s);
  const SkyLight sky = sky_of(scene, atlas, RenderOptions{}.sky_degree);
  const FrameComposite truth =
      composite_frame(scene, atlas, drops, sky, frame.background, frame.depth_m);
  report.timings_s.emplace_back("double-precision composite of the same frame",
                                seconds_since(start));
  add_frame_comparison(
      scene, frame, truth,
      fmt::format("{} at {:.2f} s", scene_file.substr(scene_file.find_last_of('/') + 1), time_s),
      report);
  const double white = scene.camera.white_cd_m2;
  add_png_check(png_bytes(frame.color, white), frame.color, white, report);
}

}  // namespace pluvia
