#include "validate/streak_prices.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "atlas/transfer.h"
#include "oscillation/water.h"
#include "raytrace/physical_rain.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {
namespace {

void append(std::vector<StreakSums>& to, const std::vector<StreakSums>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

std::string whole_cost(const std::vector<StreakRequest>& streaks) {
  std::size_t lights = 0;
  for (const StreakRequest& streak : streaks) lights += streak.lights.size();
  return fmt::format("{} streaks", lights);
}

// Light of all streaks as one request's tracer has it and as another's.
template <typename Change>
std::vector<StreakSums> changed_sums(const std::vector<StreakRequest>& streaks, Change change) {
  std::vector<StreakSums> sums;
  for (const StreakRequest& streak : streaks) {
    StreakRequest changed = streak;
    change(changed);
    append(sums, light_sums(trace_streak(changed).light, trace_streak(streak).light));
  }
  return sums;
}

// Pixels of the rectangle that the drop's sphere passes, on the average over the exposure: each
// with a share of its area, 1 inside.
std::vector<float> passed_rectangle(const StreakRequest& streak) {
  const StreakFrame& frame = streak.frame;
  const double r0_px = streak.drop.mean_radius_m / frame.pixel_m;
  const auto overlap = [](int pixel, double from, double to) {
    return std::max(0.0, std::min(pixel + 1.0, to) - std::max(1.0 * pixel, from));
  };
  std::vector<float> shares;
  for (int y = 0; y < frame.height_px; ++y) {
    const double row = overlap(y, frame.path_top_row, frame.path_top_row + frame.path_rows);
    for (int x = 0; x < frame.width_px; ++x) {
      const double column = overlap(x, frame.centre_column - r0_px, frame.centre_column + r0_px);
      shares.push_back(static_cast<float>(row * column));
    }
  }
  return shares;
}

double total(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::vector<float> times(std::vector<float> values, double factor) {
  for (float& value : values) value = static_cast<float>(factor * static_cast<double>(value));
  return values;
}

void cut_at_zero(std::vector<float>& values) {
  for (float& value : values) value = std::max(value, 0.0f);
}

// One channel of a picture of several planes.
std::vector<float> lit(const Shard& shard, const std::vector<double>& coefficients, int degree) {
  const auto count = static_cast<std::ptrdiff_t>(harmonic_count(degree));
  StreakImage image =
      lit_by_environment(shard, {{coefficients.begin(), coefficients.begin() + count}});
  cut_at_zero(image.mean);
  return std::move(image.mean);
}

}  // namespace

StreakRequest streak_of(const Preset& preset, int oscillation, double view_elevation_deg,
                        const std::vector<LightDirection>& lights) {
  const ShardKey key = {.diameter_um = diameters_of(preset).at(0), .oscillation = oscillation};
  StreakRequest request = shard_request(preset, key);
  const StreakFrame level = request.frame;
  const double cosine = std::cos(view_elevation_deg * std::numbers::pi / 180);
  request.view_elevation_deg = view_elevation_deg;
  request.frame.path_rows = level.path_rows * cosine;
  request.frame.height_px = static_cast<int>(
      std::ceil(level.height_px - level.path_rows + request.frame.path_rows - 1e-9));
  request.lights = lights;
  request.environment = {.uniform = false};
  return request;
}

std::vector<StreakSums> light_sums(const std::vector<StreakImage>& ours,
                                   const std::vector<StreakImage>& truth) {
  std::vector<StreakSums> sums;
  for (std::size_t i = 0; i < truth.size(); ++i)
    sums.push_back(streak_sums(ours.at(i).mean, truth[i].mean));
  return sums;
}

std::vector<PriceTag> order_prices(const std::vector<StreakRequest>& streaks,
                                   const std::vector<int>& orders, int most_order) {
  std::vector<std::vector<StreakSums>> sums(orders.size());
  for (StreakRequest streak : streaks) {
    streak.field.paths.max_order = most_order;
    const TracedStreak truth = trace_streak(streak);
    for (std::size_t k = 0; k < orders.size(); ++k) {
      streak.field.paths.max_order = orders[k];
      append(sums[k], light_sums(trace_streak(streak).light, truth.light));
    }
  }
  std::vector<PriceTag> tags;
  for (std::size_t k = 0; k < orders.size(); ++k)
    tags.push_back({fmt::format("orders 0 to {}", orders[k]),
                    fmt::format("orders 0 to {}", most_order), price_of(sums[k]),
                    whole_cost(streaks)});
  return tags;
}

PriceTag polarisation_price(const std::vector<StreakRequest>& streaks,
                            const BruteOptions& options) {
  std::vector<StreakSums> sums;
  BruteOptions mixed = options;
  mixed.polarised = false;
  for (const StreakRequest& streak : streaks)
    append(sums, light_sums(brute_force_streak(streak, mixed).light,
                            brute_force_streak(streak, options).light));
  return {"polarisation forgotten at each interface", "Stokes vectors, the same rays",
          price_of(sums), whole_cost(streaks)};
}

PriceTag sphere_price(const std::vector<StreakRequest>& streaks) {
  const auto sums = changed_sums(streaks, [](StreakRequest& streak) { streak.drop.modes.clear(); });
  return {"a rigid sphere", "the oscillating drop", price_of(sums), whole_cost(streaks)};
}

PriceTag dispersion_price(const std::vector<StreakRequest>& streaks) {
  const std::vector<Band> bands = rgb_bands();
  const Air air;
  std::vector<double> indices;
  for (const Band& band : bands)
    indices.push_back(drop_index(air.temperature_c, air.pressure_pa, band.wavelength_nm));
  const double mean =
      std::accumulate(indices.begin(), indices.end(), 0.0) / static_cast<double>(indices.size());
  std::vector<StreakSums> sums;
  for (StreakRequest streak : streaks) {
    streak.field.paths.refractive_index = mean;
    const TracedStreak ours = trace_streak(streak);
    for (const double index : indices) {
      streak.field.paths.refractive_index = index;
      append(sums, light_sums(ours.light, trace_streak(streak).light));
    }
  }
  const auto [least, most] = std::minmax_element(indices.begin(), indices.end());
  return {fmt::format("one index, {:.4f}", mean),
          fmt::format("red, green, blue at {:.4f} to {:.4f}", *least, *most), price_of(sums),
          whole_cost(streaks) + ", a third of the tracing"};
}

PriceTag tracer_price(const std::vector<StreakRequest>& streaks) {
  const auto sums = changed_sums(streaks, [](StreakRequest& streak) { streak.seed += 1; });
  return {"the tracer's own noise", "the same with another seed", price_of(sums),
          whole_cost(streaks)};
}

std::vector<PriceTag> coverage_prices(const std::vector<StreakRequest>& streaks) {
  std::vector<StreakSums> published, same_area;
  for (const StreakRequest& streak : streaks) {
    const std::vector<float> truth = trace_streak(streak).coverage.mean;
    const std::vector<float> rectangle = passed_rectangle(streak);
    const double r0_px = streak.drop.mean_radius_m / streak.frame.pixel_m;
    published.push_back(streak_sums(times(rectangle, 2 * r0_px / streak.frame.path_rows), truth));
    same_area.push_back(streak_sums(times(rectangle, total(truth) / total(rectangle)), truth));
  }
  const std::string saved = "a coverage picture less";
  return {{"coverage 2 r0 / path, the same everywhere (2006)", "coverage by row and column",
           price_of(published), saved},
          {"the same, with the drop's own area", "coverage by row and column", price_of(same_area),
           saved}};
}

std::vector<PriceTag> sky_prices(const std::vector<StreakRequest>& streaks, const Image& map,
                                 int headings, int most_degree) {
  std::vector<std::vector<StreakSums>> sums(static_cast<std::size_t>(most_degree) + 1);
  for (StreakRequest streak : streaks) {
    streak.lights = {{0, 170}};  // unused: the field wants one to look at
    for (int heading = 0; heading < headings; ++heading) {
      const double turn_rad = 2 * std::numbers::pi * heading / headings;
      streak.environment = {
          .uniform = false, .transfer_degree = most_degree, .map = {.radiance = map}};
      streak.environment.map.world_from_drop =
          Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      const auto coefficients = harmonic_coefficients(streak.environment.map, most_degree);
      TracedStreak traced = trace_streak(streak);
      const Shard shard = {.width_px = streak.frame.width_px,
                           .height_px = streak.frame.height_px,
                           .transfer = std::move(traced.transfer)};
      for (std::size_t c = 0; c < traced.mapped.size(); ++c) {
        for (int degree = 0; degree <= most_degree; ++degree)
          sums[static_cast<std::size_t>(degree)].push_back(
              streak_sums(lit(shard, coefficients[c], degree), traced.mapped[c].mean));
      }
    }
  }
  std::vector<PriceTag> tags;
  for (int degree = 0; degree <= most_degree; ++degree)
    tags.push_back({fmt::format("the sky to degree {}", degree), "the map itself",
                    price_of(sums[static_cast<std::size_t>(degree)]),
                    degree == 0 ? "1 cell a streak"
                                : fmt::format("{} cells a streak", harmonic_count(degree))});
  return tags;
}

}  // namespace pluvia
