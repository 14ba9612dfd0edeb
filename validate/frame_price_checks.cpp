#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "raytrace/moving_parts.h"
#include "raytrace/process_time.h"
#include "realtime/rain_renderer.h"
#include "validate/checks.h"
#include "validate/flip.h"
#include "validate/frame_prices.h"
#include "validate/picture_comparison.h"

namespace pluvia {
namespace {

struct NamedOptions {
  std::string name = {};
  RenderOptions options = {};
};

std::vector<NamedOptions> frame_variants() {
  return {{"the nearest view and light", {.lookup = LookupMode::nearest}},
          {"trilinear lookup", {.lookup = LookupMode::trilinear}},
          {"the sky's mean from everywhere", {.sky_degree = 0}},
          {"the sky to degree 1", {.sky_degree = 1}},
          {"the sky to degree 2", {.sky_degree = 2}},
          {"quads alone", {.widest_splat_px = 0}}};
}

// The coarsest that the renderer has, for the bound.
const RenderOptions coarsest = {.lookup = LookupMode::nearest, .sky_degree = 0};

struct FrameJudge {
  const StreakAtlas& atlas;
  Scene scene = {};
  ReferenceFrame truth = {};
  std::vector<DistanceTag> tags = {};
  std::optional<RainRenderer> renderer = {};

  Frame render(const RenderOptions& options) { return rendered(renderer, scene, atlas, options); }

  Distance price(const std::string& what, const Frame& frame) {
    const Distance distance = frame_distance(rain_layer(frame.color, frame.background), truth);
    tags.push_back({what, "the reference", distance});
    return distance;
  }
};

void add_pictures(const FrameJudge& judge, const Frame& frame, Report& report) {
  constexpr float gain = 8;
  const double white = judge.scene.camera.white_cd_m2;
  const Image ours = rain_layer(frame.color, frame.background);
  const Image truth = with_rain(frame.background, judge.truth.rain, 1);
  const FlipError flip = ldr_flip(cut_to_screen(truth, white), cut_to_screen(frame.color, white));
  report.comparisons.push_back(
      {.title = "A whole frame in real time and traced",
       .text = fmt::format("Near rain under a city's sky and a sun, behind it the sky alone; what "
                           "the rain changes is shown {} times as strong. Mean LDR-FLIP of the "
                           "frame as it is: {:.4f}.",
                           gain, flip.mean),
       .unit = "cd/m^2",
       .picture = {.image = with_rain(frame.background, ours, gain),
                   .white = white,
                   .caption = "real time"},
       .reference = {.image = with_rain(frame.background, judge.truth.rain, gain),
                     .white = white,
                     .caption = "reference"},
       .gain = 4,
       .maps = {{.image = flip.map, .caption = "LDR-FLIP"}}});
}

}  // namespace

void add_whole_frame_check(const Preset& preset, const StreakAtlas& atlas,
                           const std::string& data_folder, StudyDepth depth, Report& report) {
  if (!can_be_judged(atlas)) {
    report.skipped.push_back(
        "a whole frame against the reference: the atlas has not all of ten "
        "sets, three views, 74 lights and a sky");
    return;
  }
  const double start_s = process_cpu_s();
  FrameJudge judge = {.atlas = atlas, .scene = small_frame(atlas, data_folder)};
  const double samples_per_px = depth == StudyDepth::full ? 2000 : 300;
  judge.truth =
      reference_frame(judge.scene, atlas, reference_options(preset), preset, samples_per_px, 12);
  const Frame frame = judge.render({});
  const Distance distance = judge.price("real time as it is", frame);
  const Distance bound = judge.price("nearest lookup, the sky's mean", judge.render(coarsest));
  add_pictures(judge, frame, report);
  if (depth == StudyDepth::full) {
    for (const auto& [name, options] : frame_variants()) judge.price(name, judge.render(options));
  }
  report.checks.push_back(check_of(
      "reference.frame", distance, bound.relative_rmse,
      fmt::format("Rain layer of a whole frame, {} streaks in view, under a map and a sun: real "
                  "time against the reference tracer with all orders, pixel by pixel, less its "
                  "noise. The bound is the same of the coarsest lookup there is: the nearest cell "
                  "and the sky's mean.",
                  frame.streaks_in_view)));
  report.tables.push_back(distance_table("A whole frame against the reference", judge.tags));
  report.timings_s.emplace_back("a whole frame against the reference", process_cpu_s() - start_s);
}

void add_frame_prices(const std::string& scene_file, const StreakAtlas& atlas, const Preset& preset,
                      const Progress& progress, Report& report) {
  const auto step = [&](const char* what, double share) {
    if (progress) progress(what, share);
  };
  step("prices of drawing", 0);
  double start_s = process_cpu_s();
  Scene scene = scene_at(read_scene(scene_file), 0);
  scene.splashes.reset();
  scene.camera.depth_of_field.reset();
  scene.camera.width_px = 320;
  scene.camera.height_px = 180;
  for (RainSize& size : scene.rain.sizes)
    size.drops_per_m3 /= 4;  // the composite takes minutes else
  report.tables.push_back(price_table("What drawing a frame costs", drawing_prices(scene, atlas)));
  const auto add_time = [&](const char* what) {
    report.timings_s.emplace_back(what, process_cpu_s() - start_s);
    start_s = process_cpu_s();
  };
  add_time("price tags: drawing");
  step("prices of near drops", 0.6);
  if (!can_be_judged(atlas)) return;
  std::vector<DistanceTag> tags = near_drop_prices(atlas, preset);
  for (DistanceTag& tag : near_lamp_prices(atlas, preset)) tags.push_back(std::move(tag));
  report.tables.push_back(distance_table("What nearness costs", tags));
  add_time("price tags: near drops and lamps");
}

}  // namespace pluvia
