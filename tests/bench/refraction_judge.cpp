// Streaks that refract by masks against the reference tracer's picture of the same scene, and
// beside the other looks (docs/refraction.md): FLIP of the picture as a screen shows it, over all
// of it and where the drops are, and the relative RMSE of the rain layer there.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "atlas/image_io.h"
#include "raytrace/scene.h"
#include "realtime/rain_renderer.h"
#include "validate/flip.h"
#include "validate/metrics.h"

namespace pluvia {
namespace {

struct JudgeFlags {
  std::string scene = {}, atlas = {}, masks = {}, reference = {}, out = {};
  double start_s = 0;
  bool refraction_alone = false;
};

struct Truth {
  Image color = {}, rain = {};
  std::vector<float> coverage = {};
};

Truth read_truth(const std::string& file) {
  const std::vector<ExrPart> parts = parse_exr(file, read_file(file));
  const auto channel = [&](const std::string& name) -> const std::vector<float>& {
    for (const ExrChannel& found : parts.at(0).channels) {
      if (found.name == name) return found.values;
    }
    throw std::runtime_error(file + ": no channel " + name + "; expected a picture of reference");
  };
  Truth truth = {make_image(parts[0].width, parts[0].height, 3),
                 make_image(parts[0].width, parts[0].height, 3), channel("coverage")};
  const char* names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& color = channel(names[c]);
    const auto& rain = channel(std::string("rain.") + names[c]);
    for (std::size_t i = 0; i < color.size(); ++i) {
      truth.color.values[3 * i + c] = color[i];
      truth.rain.values[3 * i + c] = rain[i];
    }
  }
  return truth;
}

// Where drops are.
double mean_where(const Image& map, const std::vector<float>& coverage) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    if (!(coverage[i] > 0)) continue;
    sum += static_cast<double>(map.values[i]);
    ++count;
  }
  return sum / count;
}

// Values beyond white count as white, as the reference's own error has them.
double relative_rmse(const Image& rain, const Truth& truth, double white) {
  double square = 0, all = 0;
  const auto cut = [&](float value) {
    return std::clamp(static_cast<double>(value), -white, white);
  };
  for (std::size_t i = 0; i < rain.values.size(); ++i) {
    square += std::pow(cut(rain.values[i]) - cut(truth.rain.values[i]), 2);
    all += std::pow(cut(truth.rain.values[i]), 2);
  }
  return std::sqrt(square / all);
}

double sum_of(const Image& image) {
  double sum = 0;
  for (const float value : image.values) sum += static_cast<double>(value);
  return sum;
}

std::vector<std::pair<std::string, RenderOptions>> rows() {
  std::vector<std::pair<std::string, RenderOptions>> all = {
      {"white", {.look = StreakLook::white}},
      {"billboards of 2010", {.path = RainPath::billboards_2010}},
      {"traced nearest", {.lookup = LookupMode::nearest}},
      {"traced", {}},
      {"traced trilinear", {.lookup = LookupMode::trilinear}},
      {"sphere published", {.look = StreakLook::sphere_published}},
      {"sphere", {.look = StreakLook::sphere}}};
  for (const auto capture : {SceneCapture::cube, SceneCapture::wide}) {
    for (const int samples : {1, 5, 10, 20, 50})
      all.push_back(
          {fmt::format("refraction {} {}", capture == SceneCapture::cube ? "cube" : "wide",
                       samples),
           {.look = StreakLook::refraction, .persistence_samples = samples, .capture = capture}});
  }
  all.push_back({"refraction cube 1024 px, 50",
                 {.look = StreakLook::refraction, .persistence_samples = 50, .capture_px = 1024}});
  return all;
}

void run(const JudgeFlags& flags) {
  const Truth truth = read_truth(flags.reference);
  Scene scene = read_scene(flags.scene);
  scene.camera = camera_at(scene, flags.start_s);
  scene.camera.width_px = truth.color.width;
  scene.camera.height_px = truth.color.height;
  StreakAtlas atlas = read_atlas(flags.atlas);
  atlas.masks = read_refraction_masks(flags.masks);
  const double white = scene.camera.white_cd_m2;
  const Image shown = cut_to_screen(truth.color, white);
  if (!flags.out.empty()) write_png(flags.out + "/reference.png", truth.color, white);
  fmt::print("look,flip,flip_where_drops_are,rain_rmse,light_over_reference\n");
  for (const auto& [name, options] : rows()) {
    if (flags.refraction_alone && options.look != StreakLook::refraction) continue;
    RainRenderer renderer(scene, atlas, options);
    const Frame frame = renderer.render(flags.start_s);
    const FlipError flip = ldr_flip(shown, cut_to_screen(frame.color, white));
    Image rain = frame.color;
    for (std::size_t i = 0; i < rain.values.size(); ++i)
      rain.values[i] -= frame.background.values[i];
    fmt::print("{},{:.4f},{:.3f},{:.3f},{:.3f}\n", name, flip.mean,
               mean_where(flip.map, truth.coverage), relative_rmse(rain, truth, white),
               sum_of(frame.color) / sum_of(truth.color));
    std::fflush(stdout);
    if (flags.out.empty()) continue;
    std::string file = name;
    std::replace(file.begin(), file.end(), ' ', '_');
    write_png(flags.out + "/" + file + ".png", frame.color, white);
  }
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("Refraction by masks against the reference", "refraction_judge");
  pluvia::JudgeFlags flags;
  app.add_option("scene", flags.scene, "scene, TOML")->required();
  app.add_option("--atlas", flags.atlas, "of the same drops")->required();
  app.add_option("--masks", flags.masks, "of the same drops (pluvia masks)")->required();
  app.add_option("--reference", flags.reference, "picture of pluvia reference")->required();
  app.add_option("--start-s", flags.start_s, "time of the frame");
  app.add_flag("--refraction-alone", flags.refraction_alone,
               "for exposures in which a drop is no streak, which other looks refuse");
  app.add_option("--out", flags.out, "folder for the pictures");
  CLI11_PARSE(app, argc, argv);
  try {
    pluvia::run(flags);
  } catch (const std::exception& error) {
    fmt::print(stderr, "refraction_judge: {}\n", error.what());
    return 1;
  }
  return 0;
}
