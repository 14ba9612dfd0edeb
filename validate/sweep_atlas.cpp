#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "raytrace/streak_accuracy.h"
#include "validate/format_prices.h"
#include "validate/grid_prices.h"
#include "validate/streak_prices.h"
#include "validate/sweep_curves.h"
#include "validate/sweep_streaks.h"
#include "validate/sweep_time.h"

namespace pluvia {
namespace {

constexpr int set_of_curve = 3;  // concave, and its own mirror image
constexpr double exposure_share = 0.1;
constexpr int pictures_level = 1, truth_level = 2;  // of raytrace/streak_accuracy.h
constexpr int most_view_deg = 40;                   // traced; an atlas goes on to 80, alike

// What all settings are held against: pictures at directions that no grid has.
struct Truth {
  std::vector<LightDirection> lights = {};
  std::vector<LitView> views = {};
};

// How a renderer gets a picture for a direction.
struct Reading {
  LookupMode mode = LookupMode::nearest;
  int level = 0;  // of the pictures
  enum class Form { floats, halves, bytes } form = Form::floats;
};

bool as_traced(const Reading& reading) {
  return reading.level == 0 && reading.form == Reading::Form::floats;
}

struct Setting {
  SweepPoint point = {};
  std::size_t grid = 0;
  Reading reading = {};
};

// What is traced for a setting; several share it.
struct Grid {
  int light_step_deg = 20, view_step_deg = 20, width_px = 0;
  PictureGrid pictures = {};
};

StreakRequest base_request(Preset preset, int width_px, int level) {
  preset.width_px = width_px;
  const StreakRequest whole = streak_of(preset, set_of_curve, 0, light_grid(20));
  return at_accuracy_level(part_of(whole, exposure_share), level);
}

LitView traced_view(StreakRequest request, int view_deg) {
  request.view_elevation_deg = view_deg;
  return {view_deg, trace_streak(request).light};
}

// Views evenly over 0 .. 40 by the golden section, which no grid has.
Truth trace_truths(const Preset& preset, bool quick) {
  const std::vector<int> views = quick ? std::vector<int>{33} : std::vector<int>{32, 17, 3, 26, 11};
  Truth truth = {.lights = lights_between(quick ? 12 : 40)};
  StreakRequest request = base_request(preset, preset.width_px, quick ? 1 : truth_level);
  request.lights = truth.lights;
  truth.views.resize(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t v) { truth.views[v] = traced_view(request, views[v]); });
  return truth;
}

PictureGrid trace_grid(const Preset& preset, const Grid& grid, bool quick) {
  StreakRequest request = base_request(preset, grid.width_px, quick ? 0 : pictures_level);
  request.lights = light_grid(grid.light_step_deg);
  PictureGrid pictures = {.width_px = grid.width_px, .lights = request.lights};
  for (int view = 0; view <= most_view_deg; view += grid.view_step_deg)
    pictures.views.push_back(traced_view(request, view));
  return pictures;
}

// The mean over squares of 2^level pixels, of the row or column at the end over what is there.
std::vector<float> merged(const std::vector<float>& fine, int width, int level) {
  const int height = static_cast<int>(fine.size()) / width, side = 1 << level;
  std::vector<float> coarse;
  for (int y = 0; y < height; y += side) {
    for (int x = 0; x < width; x += side) {
      const int rows = std::min(side, height - y);
      double sum = 0;
      for (int i = 0; i < rows * side; ++i)
        sum += static_cast<double>(
            fine[static_cast<std::size_t>((y + i / side) * width + x + i % side)]);
      coarse.push_back(static_cast<float>(sum / (rows * side)));
    }
  }
  return coarse;
}

std::vector<float> in_form(const std::vector<float>& picture, Reading::Form form) {
  const float largest = *std::max_element(picture.begin(), picture.end());
  if (form == Reading::Form::halves) return as_half(picture);
  if (form == Reading::Form::bytes && largest > 0) return as_bytes(picture, largest);
  return picture;
}

// The grid as a renderer has it in that form and level.
PictureGrid kept(const PictureGrid& traced, const Reading& reading) {
  PictureGrid grid = traced;
  grid.width_px >>= reading.level;
  for (LitView& view : grid.views) {
    for (StreakImage& image : view.pictures)
      image.mean = in_form(merged(image.mean, traced.width_px, reading.level), reading.form);
  }
  return grid;
}

// All pictures of the truth, looked up; coarser ones spread over the truth's pixels.
void set_errors(const Truth& truth, int width_px, const PictureGrid& grid, Setting& setting) {
  std::vector<StreakSums> sums;
  double noise = 0, size = 0;
  const int halvings = static_cast<int>(std::lround(std::log2(width_px / grid.width_px)));
  for (const LitView& view : truth.views) {
    for (std::size_t i = 0; i < truth.lights.size(); ++i) {
      const StreakImage& exact = view.pictures[i];
      const int height = static_cast<int>(exact.mean.size()) / width_px;
      const auto found = looked_up(grid, view.elevation_deg, truth.lights[i].elevation_deg,
                                   truth.lights[i].azimuth_deg, setting.reading.mode);
      sums.push_back(
          streak_sums(enlarged(found, grid.width_px, halvings, width_px, height), exact.mean));
      size += sums.back().truth_squares;
      for (const float variance : exact.variance) noise += static_cast<double>(variance);
    }
  }
  const Price price = price_of(sums);
  setting.point.error = price.picture;
  setting.point.standard_error = price.picture_error;
  setting.point.noise = std::sqrt(noise / size);
}

std::string views_text(int step_deg) {
  std::string text;
  for (int view = 0; view <= 80; view += step_deg)
    text += fmt::format("{}{}", view > 0 ? ", " : "", view);
  return "[" + text + "]";
}

std::string keys_of(const Grid& grid) {
  return fmt::format(
      "[light] grid_step_deg = {}; [picture] view_elevations_deg = {}, width_px = {}",
      grid.light_step_deg, views_text(grid.view_step_deg), grid.width_px);
}

std::string megabytes(const Preset& preset, const Grid& grid, const Reading& reading) {
  const StreakFrame frame = gn2006_frame(preset, 0);
  const double shrink = std::ldexp(1.0 * preset.width_px / grid.width_px, reading.level);
  const double per_value = reading.form == Reading::Form::halves  ? 0.5
                           : reading.form == Reading::Form::bytes ? 0.25
                                                                  : 1;
  const double bytes =
      per_value *
      atlas_bytes(static_cast<int>(preset.oscillations.size()), grid.light_step_deg,
                  grid.view_step_deg, frame.width_px * frame.height_px) /
      (shrink * shrink);
  return fmt::format("{:.{}f} MB", bytes / 1e6, bytes < 1e8 ? 1 : 0);
}

struct Plan {
  std::vector<Grid> grids = {};
  std::vector<Setting> settings = {};
};

void add_setting(const Preset& preset, const std::string& series, const std::string& name,
                 const Reading& reading, Plan& plan) {
  const Grid& grid = plan.grids.back();
  plan.settings.push_back(
      {.point = {.series = series,
                 .setting = fmt::format("{}, {}: {}", name, lookup_name(reading.mode),
                                        megabytes(preset, grid, reading)),
                 .flags = as_traced(reading) ? fmt::format("{}; pluvia render --lookup {}",
                                                           keys_of(grid), lookup_name(reading.mode))
                                             : ""},
       .grid = plan.grids.size() - 1,
       .reading = reading});
}

// What the pictures of the last grid may be kept as.
void add_forms(const Preset& preset, Plan& plan) {
  const Grid grid = plan.grids.back();
  const std::string lights = fmt::format("lights every {}, ", grid.light_step_deg);
  for (int level = 1; level <= 3 && grid.width_px >> level > 0; ++level)
    add_setting(preset, "levels", fmt::format("{}level {}", lights, level),
                {.mode = LookupMode::trilinear, .level = level}, plan);
  add_setting(preset, "formats", lights + "half floats",
              {.mode = LookupMode::trilinear, .form = Reading::Form::halves}, plan);
  add_setting(preset, "formats", lights + "8 bits and a factor",
              {.mode = LookupMode::trilinear, .form = Reading::Form::bytes}, plan);
}

void add_grids(const Preset& preset, bool quick, Plan& plan) {
  // Of lights every 5 degrees views every 20 would decide.
  const std::vector<std::pair<int, int>> all = {{20, 20}, {20, 10}, {10, 20}, {10, 10}, {5, 10}};
  const std::vector<std::pair<int, int>> few = {{20, 20}, {10, 20}};
  const auto& steps = quick ? few : all;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto [lights, views] = steps[i];
    plan.grids.push_back(
        {.light_step_deg = lights, .view_step_deg = views, .width_px = preset.width_px});
    for (const LookupMode mode :
         {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear})
      add_setting(preset, fmt::format("angles, {}", lookup_name(mode)),
                  fmt::format("lights every {}, views every {}", lights, views), {.mode = mode},
                  plan);
    if (i + 1 == steps.size() || steps[i + 1].first != lights) add_forms(preset, plan);
  }
}

void add_widths(const Preset& preset, Plan& plan) {
  for (const int width : {preset.width_px / 2, preset.width_px / 4}) {
    if (width < 4) continue;
    plan.grids.push_back({.light_step_deg = 10, .view_step_deg = 20, .width_px = width});
    add_setting(preset, "widths", fmt::format("lights every 10, views every 20, {} px wide", width),
                {.mode = LookupMode::trilinear}, plan);
  }
}

// Traces every grid once in each round, and keeps the first round's.
std::vector<std::vector<double>> trace_grids(const Preset& preset, const SweepInputs& inputs,
                                             const Progress& progress, Plan& plan) {
  std::vector<std::function<void(int)>> jobs;
  for (Grid& grid : plan.grids) {
    jobs.push_back([&](int round) {
      PictureGrid pictures = trace_grid(preset, grid, inputs.quick);
      if (round == 0) grid.pictures = std::move(pictures);
    });
  }
  return time_interleaved(jobs, inputs.repeats, [&](double share) {
    if (progress) progress("grids", 0.2 + 0.7 * share);
  });
}

// Making the pictures takes what tracing them takes, and bringing them into their form.
void finish(const Truth& truth, const Preset& preset,
            const std::vector<std::vector<double>>& grid_times, const Plan& plan,
            Setting& setting) {
  const Grid& grid = plan.grids[setting.grid];
  std::vector<double> times = grid_times[setting.grid];
  PictureGrid formed;
  if (!as_traced(setting.reading)) {
    const auto forming =
        time_interleaved({[&](int) { formed = kept(grid.pictures, setting.reading); }},
                         static_cast<int>(times.size()));
    for (std::size_t i = 0; i < times.size(); ++i) times[i] += forming[0][i];
  }
  set_times(times, setting.point);
  set_errors(truth, preset.width_px, as_traced(setting.reading) ? grid.pictures : formed, setting);
}

std::string text_of(const Preset& preset, const Truth& truth, bool quick) {
  return fmt::format(
      "{} directions of light from {} views, none of which a grid has, looked up in pictures of "
      "set "
      "{} ({} px wide, level {} of the field) and spread over the pixels of streaks traced there "
      "(level {}). Bright streaks decide; the tracer's own noise is in the error. Megabytes are "
      "those of {} sets without coarser levels. A coarser level or picture is judged at full size: "
      "right for a drop that is large in the picture. What a lookup takes is in the renderer's "
      "curve; half floats and bytes measure, and are not offered.",
      truth.lights.size(), truth.views.size(), set_of_curve, preset.width_px,
      quick ? 0 : pictures_level, quick ? 1 : truth_level, preset.oscillations.size());
}

}  // namespace

SweepCurve sweep_atlas(const SweepInputs& inputs, const Progress& progress) {
  const Preset preset = read_preset(inputs.preset_file);
  if (progress) progress("streaks between the grids", 0);
  const Truth truth = trace_truths(preset, inputs.quick);
  Plan plan;
  add_grids(preset, inputs.quick, plan);
  if (!inputs.quick) add_widths(preset, plan);
  const auto times = trace_grids(preset, inputs, progress, plan);
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  SweepCurve curve = {
      .name = "atlas",
      .title = "The atlas: directions, sizes and forms of its pictures",
      .time_label = fmt::format("processor time of {} of one set's pictures, views 0 to {} [s]",
                                exposure_share, most_view_deg),
      .error_label = "relative RMSE of streaks between the grid's directions",
      .text = text_of(preset, truth, inputs.quick),
      .whole = fmt::format("the pictures of {} sets, views 0 to {}, on {} cores",
                           preset.oscillations.size(), most_view_deg, cores),
      .whole_factor = static_cast<double>(preset.oscillations.size()) / (exposure_share * cores)};
  for (Setting& setting : plan.settings) {
    finish(truth, preset, times, plan, setting);
    curve.points.push_back(setting.point);
  }
  const std::string standard = "lights every 20, views every 20, view-linear";
  for (const SweepPoint& point : curve.points) {
    if (point.setting.starts_with(standard)) curve.standard = point.setting;
  }
  return curve;
}

}  // namespace pluvia
