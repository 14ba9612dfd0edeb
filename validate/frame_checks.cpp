#include <algorithm>
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

std::string name_of(const std::string& file) {
  return file.substr(file.find_last_of('/') + 1);
}

// The scene at its time, without what the composite does not know: it lays down streaks alone,
// behind a pinhole, and knows no shade.
Scene scene_for_composite(const CheckedFrame& checked, Report& report) {
  Scene scene = scene_at(read_scene(checked.scene_file), checked.time_s);
  const auto leave_out = [&](bool called_for, const char* what) {
    if (!called_for) return;
    report.skipped.push_back(fmt::format("{} of {} in {}: the exact composite has none", what,
                                         name_of(checked.scene_file), checked.prefix));
  };
  leave_out(scene.splashes.has_value(), "splashes");
  leave_out(scene.camera.depth_of_field.has_value(), "depth of field");
  leave_out(std::any_of(scene.lights.begin(), scene.lights.end(),
                        [](const Light& light) { return light.shadow; }),
            "shadows");
  scene.splashes.reset();
  scene.camera.depth_of_field.reset();
  for (Light& light : scene.lights) light.shadow = false;
  Camera& camera = scene.camera;
  if (checked.most_width_px > 0 && camera.width_px > checked.most_width_px) {
    camera.height_px = std::max(1, camera.height_px * checked.most_width_px / camera.width_px);
    camera.width_px = checked.most_width_px;
  }
  return scene;
}

}  // namespace

void add_frame_comparison(const std::string& prefix, const Scene& scene, const Frame& frame,
                          const FrameComposite& truth, const std::string& what, Report& report) {
  const Image ours = rain_layer(frame.color, frame.background);
  Check check = deviation(
      prefix + ".composite", relative_rmse(ours, truth.rain), 0, 0.02, "relative RMSE",
      fmt::format("Rain-only signal (frame minus the frame without rain) of {}, {} "
                  "streaks in view: the real-time renderer against exact areas of every texel over "
                  "every pixel in double precision, drops composited in depth order, from the same "
                  "drops, database, background and depth. Both are deterministic: no uncertainty.",
                  what, frame.streaks_in_view));
  report.checks.push_back(check);

  const double white = scene.camera.white_cd_m2;
  report.comparisons.push_back(
      {.title = fmt::format("A frame of rain: {}", what),
       .text = "The scene with rain as the real-time renderer draws it, and without.",
       .unit = "cd/m^2",
       .picture = {.image = frame.color, .white = white, .caption = "with rain"},
       .reference = {.image = frame.background, .white = white, .caption = "without rain"},
       .gain = 4});
  report.comparisons.push_back(
      {.title =
           fmt::format("The rain of {} alone, against the exact composite of the same atlas", what),
       .text = "Frame minus background, four times as bright as above.",
       .unit = "cd/m^2",
       .picture = {.image = ours, .white = white / 4, .caption = "real-time"},
       .reference = {.image = truth.rain, .white = white / 4, .caption = "exact composite"},
       .gain = 16});
  const auto comparing = Clock::now();
  add_picture_checks(prefix,
                     {.picture = frame.color,
                      .reference = truth.color,
                      .dry = frame.background,
                      .white = white,
                      .streaks = truth.streaks},
                     report);
  report.timings_s.emplace_back("picture metrics", seconds_since(comparing));
}

void add_frame_check(const CheckedFrame& checked, const StreakAtlas& atlas, Report& report) {
  const Scene scene = scene_for_composite(checked, report);
  report.seeds.emplace_back("drops of " + checked.prefix, std::to_string(scene.rain.seed));
  RainRenderer renderer(scene, atlas);
  renderer.render(checked.time_s);  // the first frame compiles and uploads
  const Frame frame = renderer.render(checked.time_s);
  for (const PassCost& cost : frame.costs)
    report.timings_s.emplace_back("real-time " + checked.prefix + ": " + cost.pass, cost.wall_s);

  const auto start = Clock::now();
  const auto drops = drops_with_sets(scene, set_numbers(atlas), checked.time_s);
  const SkyLight sky = sky_of(scene, atlas, RenderOptions{}.sky_degree);
  const FrameComposite truth =
      composite_frame(scene, atlas, drops, sky, frame.background, frame.depth_m);
  report.timings_s.emplace_back("double-precision composite of " + checked.prefix,
                                seconds_since(start));
  add_frame_comparison(checked.prefix, scene, frame, truth,
                       fmt::format("{} at {:.2f} s", name_of(checked.scene_file), checked.time_s),
                       report);
  const double white = scene.camera.white_cd_m2;
  add_png_check(checked.prefix, png_bytes(frame.color, white), frame.color, white, report);
}

}  // namespace pluvia
