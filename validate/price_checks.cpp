#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "atlas/image_io.h"
#include "raytrace/process_time.h"
#include "validate/checks.h"
#include "validate/format_prices.h"
#include "validate/grid_prices.h"
#include "validate/size_prices.h"
#include "validate/streak_prices.h"

namespace pluvia {
namespace {

using Tags = std::vector<PriceTag>;

void append(Tags& to, Tags from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

// What is traced for a depth of study: drops that are their own mirror images, narrower than the
// preset's pictures, for an approximation's error does not ask for the finest pixels.
struct StudiedStreaks {
  std::vector<int> sets = {5, 7};
  std::vector<double> views_deg = {20};
  int light_step = 12;  // of the preset's lights, every so many
  int width_px = 16;
};

StudiedStreaks studied(StudyDepth depth) {
  if (depth == StudyDepth::brief) return {};
  return {.views_deg = {0, 40}, .light_step = 1};
}

std::vector<StreakRequest> streaks_of(Preset preset, const StudiedStreaks& study) {
  preset.width_px = study.width_px;
  std::vector<LightDirection> lights;
  for (std::size_t i = 0; i < preset.lights.size(); i += static_cast<std::size_t>(study.light_step))
    lights.push_back(preset.lights[i]);
  std::vector<StreakRequest> streaks;
  for (const int set : study.sets) {
    for (const double view_deg : study.views_deg)
      streaks.push_back(streak_of(preset, set, view_deg, lights));
  }
  return streaks;
}

// Adds a table of the tags that `measure` makes, and the time it took.
template <typename Measure>
void add_table(const std::string& title, Report& report, Measure measure) {
  const double start_s = process_cpu_s();
  report.tables.push_back(price_table(title, measure()));
  report.timings_s.emplace_back("price tags: " + title, process_cpu_s() - start_s);
}

Tags single_streak_tags(const std::vector<StreakRequest>& streaks, StudyDepth depth) {
  const bool full = depth == StudyDepth::full;
  Tags tags =
      order_prices(streaks, full ? std::vector{1, 2, 3, 5} : std::vector{1, 2, 3}, full ? 8 : 5);
  tags.push_back(polarisation_price(
      streaks, {.replicates = 4, .instants = full ? 256 : 96, .rays_per_instant = 1000}));
  tags.push_back(sphere_price(streaks));
  append(tags, coverage_prices(streaks));
  if (!full) return tags;
  tags.push_back(dispersion_price(streaks));
  tags.push_back(tracer_price(streaks));
  return tags;
}

}  // namespace

void add_streak_prices(const Preset& preset, const std::string& data_folder, StudyDepth depth,
                       const Progress& progress, Report& report) {
  const auto step = [&](const char* what, double share) {
    if (progress) progress(what, share);
  };
  const std::vector<StreakRequest> streaks = streaks_of(preset, studied(depth));
  step("prices of single streaks", 0);
  add_table("What each approximation of a streak costs", report,
            [&] { return single_streak_tags(streaks, depth); });
  if (depth == StudyDepth::brief) return;
  step("prices of harmonics", 0.2);
  add_table("What the degree of the sky costs", report, [&] {
    return sky_prices(streaks, read_environment_map(data_folder + "/environments/city.exr"), 4, 8);
  });
  step("prices of the grid of lights", 0.4);
  add_table("What the grid of lights costs", report,
            [&] { return light_grid_prices(streaks, 5, lights_between(60)); });
  step("prices of the grid of views", 0.6);
  const std::vector<StreakRequest> few = streaks_of(preset, {.light_step = 5});
  add_table("What the grid of views costs", report, [&] {
    return view_grid_prices(few, 5, {3, 7, 11, 16, 22, 28, 34, 37}, 40);
  });
  step("prices of sizes", 0.9);
  add_table("What one size for all drops costs", report, [&] {
    return size_prices(few, {0.5e-3, 0.8e-3, 1.2e-3, 2e-3, 2.5e-3});
  });
}

void add_format_prices(const StreakAtlas& atlas, Report& report) {
  const int last = static_cast<int>(atlas.layers.size()) - 1;
  if (lit_cells(atlas, last) < 2) {
    report.skipped.push_back(
        "tags.half, what the form of the atlas costs: fewer than two lit cells");
    return;
  }
  const Tags tags = format_prices(atlas, last);
  report.tables.push_back(price_table("What the form of the atlas costs", tags));
  const auto half = std::find_if(tags.begin(), tags.end(), [](const PriceTag& tag) {
    return tag.approximation.find("half floats") != std::string::npos;
  });
  report.checks.push_back(deviation(
      "tags.half", half->price.picture, 0, 0x1p-11, "relative RMSE",
      "Pictures of the atlas's last set, finest level, rounded to half floats, against floats. A "
      "half float is off by at most 2^-11 of itself, unless it is below 6e-5: an atlas too dim for "
      "half floats fails. Both are deterministic: no uncertainty."));
}

}  // namespace pluvia
