#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>

#include "raytrace/rain_space.h"
#include "realtime/rain_renderer.h"
#include "validate/batch_judge.h"
#include "validate/metrics.h"
#include "validate/picture_comparison.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_frames.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

constexpr double fullest_reach = 1.5;  // over the culling radius
constexpr int fullest_samples = 2;     // along each side of a pixel

// Every streak by all of its columns that a pixel could tell apart, in the finest light there is.
constexpr RenderOptions fullest = {
    .max_texel_px = 0.25, .widest_splat_px = 0, .lookup = LookupMode::trilinear, .sky_degree = 8};

// One way to draw the scene.
struct Drawn {
  SweepPoint point = {};
  RenderOptions options = {};
  double reach = 1;                  // of the drops, over the culling radius
  std::vector<double> errors = {};   // of each instant
  std::vector<double> times_s = {};  // of each instant and repeat
};

struct Instant {
  double time_s = 0;
  Image rain = {};  // the reference's, as below
};

// The streaks alone.
Scene judged_scene(const std::string& file, bool quick) {
  Scene scene = read_scene(file);
  scene.splashes.reset();
  const RainSpace space = make_rain_space(scene);
  scene.rain.culling_radius_m = space.culling_radius_m;
  scene.rain.local_height_m = space.local_height_m;
  if (quick) {
    scene.camera.width_px = std::max(1, scene.camera.width_px / 4);
    scene.camera.height_px = std::max(1, scene.camera.height_px / 4);
  }
  return scene;
}

// The same drops out to another distance. The height of the local space stays: another height is
// other rain.
Scene with_reach(Scene scene, double reach) {
  scene.rain.culling_radius_m *= reach;
  return scene;
}

Drawn drawn(const std::string& series, const RenderOptions& options) {
  const std::string lookup = lookup_name(options.lookup);
  return {.point = {.series = series, .setting = lookup, .flags = "--lookup " + lookup},
          .options = options};
}

void add_lesser(LookupMode lookup, const Scene& scene, bool quick, std::vector<Drawn>& all) {
  const std::string mode = lookup_name(lookup);
  const auto add = [&](const std::string& what, const std::string& value, const std::string& flag,
                       RenderOptions options, double reach = 1) {
    options.lookup = lookup;
    Drawn way = drawn(what, options);
    way.point.setting += ", " + what + " " + value;
    way.point.flags = flag.empty() ? "" : way.point.flags + flag;
    way.reach = reach;
    way.point.series += ", " + mode;
    all.push_back(way);
  };
  for (const double n : {4.0, 1.0}) {
    if (quick && n != 4) continue;
    add("far streaks", fmt::format("{}", n), fmt::format(" --far-streaks {}", n),
        {.far_streaks = n});
  }
  for (const double reach : {0.5, 0.75, 1.25, 1.5}) {
    if (quick && reach != 0.5) continue;
    const double radius_m = reach * scene.rain.culling_radius_m;
    add("drops out to", fmt::format("{:.3g} m", radius_m),
        fmt::format("; [rain] culling_radius_m = {:.4g}, local_height_m = {:.6g}", radius_m,
                    scene.rain.local_height_m),
        {}, reach);
  }
  for (const int degree : {0, 1, 2}) {
    if (quick || scene.environment.map_file.empty()) continue;
    add("sky degree", fmt::format("{}", degree), fmt::format(" --sky-degree {}", degree),
        {.sky_degree = degree});
  }
}

std::vector<Drawn> ways_to_draw(const Scene& scene, bool quick) {
  std::vector<Drawn> all;
  for (const auto lookup : {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear}) {
    all.push_back(drawn("lookup", {.lookup = lookup}));
  }
  add_lesser(LookupMode::view_linear, scene, quick, all);
  add_lesser(LookupMode::trilinear, scene, quick, all);
  const auto texels = [&](const std::string& what, RenderOptions options) {
    options.lookup = LookupMode::trilinear;
    Drawn way = drawn("texels, trilinear", options);
    way.point.setting += ", " + what;
    way.point.flags.clear();
    all.push_back(way);
  };
  texels("every streak a quad", {.widest_splat_px = 0});
  texels("walked up to 3 px", {.widest_splat_px = 3});
  return all;
}

// What rain changes on a screen: what is brighter than white is white. Else one panel of a lamp
// that a streak dims, or misses by half a pixel, is all of the error.
Image shown_rain(const Image& color, const Image& background, const Scene& scene) {
  const double white = scene.camera.white_cd_m2;
  return rain_layer(cut_to_screen(color, white), cut_to_screen(background, white));
}

// Means of fullest_samples x fullest_samples pixels.
Image averaged(const Image& image) {
  constexpr float share = 1.0F / (fullest_samples * fullest_samples);
  Image result = make_image(image.width / fullest_samples, image.height / fullest_samples, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        result.at(x / fullest_samples, y / fullest_samples, c) += share * image.at(x, y, c);
      }
    }
  }
  return result;
}

Instant fullest_rain(const Scene& scene, const StreakAtlas& atlas, RainRenderer& renderer,
                     double time_s) {
  Scene full = with_reach(scene, fullest_reach);
  full.camera.width_px *= fullest_samples;
  full.camera.height_px *= fullest_samples;
  renderer.remake(full, atlas, fullest);
  const Frame frame = renderer.render(time_s);
  return {time_s, shown_rain(averaged(frame.color), averaged(frame.background), scene)};
}

// Every instant of one way, once. The first frame after a remake compiles, and is not timed.
void draw_all(const Scene& scene, const StreakAtlas& atlas, const std::vector<Instant>& instants,
              bool first_round, RainRenderer& renderer, Drawn& way) {
  renderer.remake(with_reach(scene, way.reach), atlas, way.options);
  renderer.render(instants.front().time_s);
  for (const Instant& instant : instants) {
    const Frame frame = renderer.render(instant.time_s);
    way.times_s.push_back(rain_time_s(frame, renderer.gl_info()));
    if (!first_round) continue;
    way.errors.push_back(
        relative_rmse(shown_rain(frame.color, frame.background, scene), instant.rain));
  }
}

SweepCurve curve_of(const std::vector<Drawn>& ways, const SweepInputs& inputs, const GlInfo& info,
                    const Scene& scene, std::size_t instants) {
  const std::string name = std::filesystem::path(inputs.scene_file).filename().string();
  SweepCurve curve = {
      .name = "renderer",
      .title = "A frame of rain in real time: " + name,
      .time_label = on_processor(info) ? "processor time of the rain [s]" : "time of the rain [s]",
      .error_label = "relative RMSE of the rain on screen",
      .text = fmt::format(
          "{} x {} px on {}, {} instants, {} repeats. Against the same rain drawn as quads alone, "
          "{} "
          "x {} samples a pixel, out to {} times the culling radius of {:.3g} m, in trilinear "
          "light and all of "
          "the atlas's harmonics: what the atlas is off is not in it.",
          scene.camera.width_px, scene.camera.height_px, info.renderer, instants, inputs.repeats,
          fullest_samples, fullest_samples, fullest_reach, scene.rain.culling_radius_m),
      .whole = "the rain of a frame of " + name,
      .standard = lookup_name(RenderOptions{}.lookup)};
  for (const Drawn& way : ways) {
    SweepPoint point = way.point;
    set_times(way.times_s, point);
    const bool spread = way.errors.size() > 1;
    const MeanAndError error =
        spread ? mean_and_error(way.errors) : MeanAndError{.mean = way.errors.front()};
    point.error = error.mean;
    point.standard_error = error.standard_error;
    curve.points.push_back(point);
  }
  return curve;
}

}  // namespace

SweepCurve sweep_renderer(const SweepInputs& inputs, const Progress& progress) {
  const Scene scene = judged_scene(inputs.scene_file, inputs.quick);
  const StreakAtlas atlas = read_atlas(inputs.atlas_folder);
  RainRenderer renderer(scene, atlas);
  std::vector<Instant> instants;
  for (const double time_s : {1.0, 1.4}) {
    if (progress) progress("reference", 0.05 * static_cast<double>(instants.size()));
    instants.push_back(fullest_rain(scene, atlas, renderer, time_s));
  }
  std::vector<Drawn> ways = ways_to_draw(scene, inputs.quick);
  for (int round = 0; round < inputs.repeats; ++round) {
    for (std::size_t k = 0; k < ways.size(); ++k) {
      draw_all(scene, atlas, instants, round == 0, renderer, ways[k]);
      const double done = round + static_cast<double>(k + 1) / static_cast<double>(ways.size());
      if (progress) progress(ways[k].point.setting, 0.15 + 0.85 * done / inputs.repeats);
    }
  }
  return curve_of(ways, inputs, renderer.gl_info(), scene, instants.size());
}

}  // namespace pluvia
