#include "validate/size_prices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "raytrace/streak_placement.h"
#include "validate/streak_prices.h"

namespace pluvia {
namespace {

constexpr double no_end = std::numeric_limits<double>::infinity();

// Of one column: sums of the rows above row 0, 1, .. height.
std::vector<double> sums_above(const StreakImage& picture, const StreakFrame& frame, int column) {
  std::vector<double> sums = {0};
  for (int y = 0; y < frame.height_px; ++y) {
    const auto at = static_cast<std::size_t>(y * frame.width_px + column);
    sums.push_back(sums.back() + static_cast<double>(picture.mean[at]));
  }
  return sums;
}

double sum_above(const std::vector<double>& sums, double row) {
  const double inside = std::clamp(row, 0.0, static_cast<double>(sums.size() - 1));
  const auto below = std::min(static_cast<std::size_t>(inside), sums.size() - 2);
  return std::lerp(sums[below], sums[below + 1], inside - static_cast<double>(below));
}

// Where the rows of the wanted picture's repetition `k` lie in the known picture.
struct Repetition {
  double top = 0;        // of both frames
  double path_rows = 0;  // of one repetition
  double known_rows = 0;
  double first = 0;  // row of the wanted picture that is row 0 of the repetition
  double end = 0;    // no row beyond: the shutter has closed

  double known_row(double row) const {
    return cell_row(std::min(row, end) - first, top, path_rows, known_rows);
  }
};

}  // namespace

StreakRequest of_radius(const StreakRequest& request, double radius_m) {
  StreakRequest other = request;
  const double ratio = radius_m / request.drop.mean_radius_m;
  StreakFrame& frame = other.frame;
  other.drop.mean_radius_m = radius_m;
  frame.pixel_m *= ratio;
  frame.path_rows *= std::sqrt(ratio) / ratio;
  frame.height_px = static_cast<int>(
      std::ceil(request.frame.height_px - request.frame.path_rows + frame.path_rows - 1e-9));
  return other;
}

double pictures_in_exposure(const StreakRequest& known, const StreakRequest& wanted) {
  return std::pow(known.drop.mean_radius_m / wanted.drop.mean_radius_m, 1.5) * wanted.exposure_s /
         known.exposure_s;
}

std::vector<float> repeated(const StreakImage& picture, const StreakRequest& known,
                            const StreakRequest& wanted, double pictures) {
  const StreakFrame& frame = wanted.frame;
  const auto width = static_cast<std::size_t>(frame.width_px);
  std::vector<double> sum(width * static_cast<std::size_t>(frame.height_px), 0.0);
  const double each = frame.path_rows / pictures;
  for (int column = 0; column < frame.width_px; ++column) {
    const std::vector<double> above = sums_above(picture, known.frame, column);
    for (int k = 0; k < pictures; ++k) {
      const bool is_cut = k + 1 > pictures;
      const Repetition part = {frame.path_top_row, each, known.frame.path_rows, k * each,
                               is_cut ? frame.path_top_row + frame.path_rows : no_end};
      for (int y = 0; y < frame.height_px; ++y) {
        sum[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(column)] +=
            (sum_above(above, part.known_row(y + 1)) - sum_above(above, part.known_row(y))) /
            pictures;
      }
    }
  }
  return {sum.begin(), sum.end()};
}

std::vector<PriceTag> size_prices(const std::vector<StreakRequest>& known,
                                  const std::vector<double>& radii_m) {
  std::vector<PriceTag> tags;
  std::vector<TracedStreak> pictures;
  for (const StreakRequest& request : known) pictures.push_back(trace_streak(request));
  for (const double radius_m : radii_m) {
    std::vector<StreakSums> stretched, tiled;
    double times = 0;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const StreakRequest wanted = of_radius(known[i], radius_m);
      times = pictures_in_exposure(known[i], wanted);
      const TracedStreak truth = trace_streak(wanted);
      for (std::size_t k = 0; k < truth.light.size(); ++k) {
        const StreakImage& picture = pictures[i].light[k];
        stretched.push_back(
            streak_sums(repeated(picture, known[i], wanted, 1), truth.light[k].mean));
        tiled.push_back(
            streak_sums(repeated(picture, known[i], wanted, times), truth.light[k].mean));
      }
    }
    const std::string drop = fmt::format("pictures of {:.1f} mm for a drop of {:.1f} mm",
                                         2e3 * known.at(0).drop.mean_radius_m, 2e3 * radius_m);
    tags.push_back({drop + ", stretched", "traced at that size", price_of(stretched), ""});
    tags.push_back({fmt::format("{}, {:.2f} times", drop, times), "traced at that size",
                    price_of(tiled), "no database of that size"});
  }
  return tags;
}

}  // namespace pluvia
