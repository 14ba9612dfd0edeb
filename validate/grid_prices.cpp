#include "validate/grid_prices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "validate/streak_prices.h"

namespace pluvia {
namespace {

int place_of(const std::vector<LightDirection>& lights, const LightDirection& light) {
  const auto found = std::find(lights.begin(), lights.end(), light);
  if (found == lights.end())
    throw std::invalid_argument(fmt::format("no light {}", light_name(light)));
  return static_cast<int>(found - lights.begin());
}

// What atlas_lookup.h needs of an atlas.
StreakAtlas tables_of(const PictureGrid& grid) {
  StreakAtlas atlas;
  atlas.lights = grid.lights;
  for (const LitView& view : grid.views)
    atlas.views.push_back({.elevation_deg = view.elevation_deg});
  return atlas;
}

void add_picture(const std::vector<float>& picture, double weight, bool flipped, int width_px,
                 std::vector<double>& sum) {
  const auto width = static_cast<std::size_t>(width_px);
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const std::size_t column = i % width;
    const std::size_t from = flipped ? i - column + width - 1 - column : i;
    sum[i] += weight * static_cast<double>(picture[from]);
  }
}

std::vector<int> steps_to(int least_step_deg) {
  std::vector<int> steps;
  for (int step = 20; step >= least_step_deg; step /= 2) steps.push_back(step);
  return steps;
}

PictureGrid one_view(const StreakRequest& streak, const TracedStreak& traced) {
  const auto elevation = static_cast<int>(std::lround(streak.view_elevation_deg));
  return {.width_px = streak.frame.width_px,
          .lights = streak.lights,
          .views = {{elevation, traced.light}}};
}

const char* name_of(LookupMode mode) {
  switch (mode) {
    case LookupMode::nearest:
      return "nearest";
    case LookupMode::view_linear:
      return "linear between two views";
    case LookupMode::trilinear:
      return "trilinear";
  }
  return "";
}

// A price for each grid and mode.
struct GridPrice {
  int step_deg = 20;
  LookupMode mode = LookupMode::nearest;
  std::vector<StreakSums> sums = {};
};

std::vector<GridPrice> grids_and_modes(int least_step_deg, const std::vector<LookupMode>& modes) {
  std::vector<GridPrice> prices;
  for (const int step : steps_to(least_step_deg)) {
    for (const LookupMode mode : modes) prices.push_back({step, mode});
  }
  return prices;
}

std::vector<int> views_of(int step_deg, int most_view_deg) {
  std::vector<int> views;
  for (int view = 0; view <= most_view_deg; view += step_deg) views.push_back(view);
  return views;
}

// Over those of the database of 2006.
double bytes_ratio(int light_step_deg, int view_step_deg) {
  return atlas_bytes(1, light_step_deg, view_step_deg, 1) / atlas_bytes(1, 20, 20, 1);
}

LitView lit_view(StreakRequest streak, int view_deg) {
  streak.view_elevation_deg = view_deg;
  return {view_deg, trace_streak(streak).light};
}

// Every light of `truth` looked up in those views.
void add_view(const PictureGrid& grid, const LitView& truth, GridPrice& price) {
  for (std::size_t i = 0; i < grid.lights.size(); ++i) {
    const LightDirection& light = grid.lights[i];
    price.sums.push_back(streak_sums(
        looked_up(grid, truth.elevation_deg, light.elevation_deg, light.azimuth_deg, price.mode),
        truth.pictures[i].mean));
  }
}

}  // namespace

std::vector<LightDirection> lights_between(int count) {
  const std::vector<LightDirection> grid = light_grid(5);
  std::vector<LightDirection> lights;
  // Heights of equal area, azimuths by the golden section.
  for (int i = 0; i < count; ++i) {
    const double height = -1 + (2 * i + 1.0) / count;
    const double elevation = std::asin(height) * 180 / std::numbers::pi;
    const double azimuth = 180 * std::fmod((i + 0.5) * std::numbers::phi, 1.0);
    LightDirection light = {static_cast<int>(std::lround(elevation)),
                            static_cast<int>(std::lround(azimuth))};
    const bool known = std::find(grid.begin(), grid.end(), light) != grid.end();
    if (known) light.azimuth_deg += light.azimuth_deg < 90 ? 1 : -1;
    lights.push_back(light);
  }
  return lights;
}

PictureGrid part_of(const PictureGrid& grid, const std::vector<LightDirection>& lights) {
  PictureGrid part = {.width_px = grid.width_px, .lights = lights};
  for (const LitView& view : grid.views) {
    LitView& kept = part.views.emplace_back();
    kept.elevation_deg = view.elevation_deg;
    for (const LightDirection& light : lights)
      kept.pictures.push_back(
          view.pictures[static_cast<std::size_t>(place_of(grid.lights, light))]);
  }
  return part;
}

std::vector<float> looked_up(const PictureGrid& grid, double view_elevation_deg,
                             double light_elevation_deg, double light_azimuth_deg,
                             LookupMode mode) {
  const StreakAtlas tables = tables_of(grid);
  const FoldedAngles angles =
      fold_angles(view_elevation_deg, light_elevation_deg, light_azimuth_deg, 0);
  const CellMix mix = mix_cells(tables, light_rows(tables), angles, mode);
  std::vector<double> sum(grid.views.at(0).pictures.at(0).mean.size(), 0.0);
  for (std::size_t v = 0; v < 2; ++v) {
    const LitView& view = grid.views[static_cast<std::size_t>(mix.view[v])];
    for (const LightTap& tap : mix.lights) {
      const double weight = mix.view_weight[v] * tap.weight;
      if (weight == 0) continue;
      add_picture(view.pictures[static_cast<std::size_t>(tap.light)].mean, weight,
                  angles.mirrored != tap.mirrored, grid.width_px, sum);
    }
  }
  return {sum.begin(), sum.end()};
}

std::vector<PriceTag> light_grid_prices(const std::vector<StreakRequest>& streaks,
                                        int least_step_deg,
                                        const std::vector<LightDirection>& between) {
  auto prices = grids_and_modes(least_step_deg, {LookupMode::nearest, LookupMode::trilinear});
  for (StreakRequest streak : streaks) {
    streak.lights = light_grid(least_step_deg);
    const std::size_t known = streak.lights.size();
    streak.lights.insert(streak.lights.end(), between.begin(), between.end());
    const TracedStreak traced = trace_streak(streak);
    const PictureGrid all = one_view(streak, traced);
    for (GridPrice& price : prices) {
      const PictureGrid grid = part_of(all, light_grid(price.step_deg));
      for (std::size_t i = 0; i < between.size(); ++i)
        price.sums.push_back(
            streak_sums(looked_up(grid, streak.view_elevation_deg, between[i].elevation_deg,
                                  between[i].azimuth_deg, price.mode),
                        traced.light[known + i].mean));
    }
  }
  std::vector<PriceTag> tags;
  for (const GridPrice& price : prices)
    tags.push_back({fmt::format("lights every {} degrees, {}", price.step_deg, name_of(price.mode)),
                    "traced in between", price_of(price.sums),
                    fmt::format("{} lights, {:.1f} x the bytes", light_grid(price.step_deg).size(),
                                bytes_ratio(price.step_deg, 20))});
  return tags;
}

std::vector<PriceTag> view_grid_prices(const std::vector<StreakRequest>& streaks,
                                       int least_step_deg, const std::vector<int>& between_deg,
                                       int most_view_deg) {
  auto prices = grids_and_modes(least_step_deg, {LookupMode::nearest, LookupMode::view_linear});
  for (const StreakRequest& streak : streaks) {
    std::vector<LitView> views, truths;
    for (const int view : views_of(least_step_deg, most_view_deg))
      views.push_back(lit_view(streak, view));
    for (const int view : between_deg) truths.push_back(lit_view(streak, view));
    for (GridPrice& price : prices) {
      PictureGrid grid = {.width_px = streak.frame.width_px, .lights = streak.lights};
      for (const LitView& view : views) {
        if (view.elevation_deg % price.step_deg == 0) grid.views.push_back(view);
      }
      for (const LitView& truth : truths) add_view(grid, truth, price);
    }
  }
  std::vector<PriceTag> tags;
  for (const GridPrice& price : prices)
    tags.push_back(
        {fmt::format("views every {} degrees, {}", price.step_deg, name_of(price.mode)),
         "traced in between", price_of(price.sums),
         fmt::format("{} views of 0 .. 80, {:.1f} x the bytes", views_of(price.step_deg, 80).size(),
                     bytes_ratio(20, price.step_deg))});
  return tags;
}

double atlas_bytes(int sets, int light_step_deg, int view_step_deg, double cell_px) {
  double heights = 0;  // over that of view 0, but for the ends
  for (const int view : views_of(view_step_deg, 80))
    heights += std::cos(view * std::numbers::pi / 180);
  const double cells = static_cast<double>(light_grid(light_step_deg).size());
  return 4.0 * sets * cells * heights * cell_px;
}

}  // namespace pluvia
