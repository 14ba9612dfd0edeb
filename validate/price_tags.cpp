#include "validate/price_tags.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

struct Ratio {
  double value = 0, error = 0;
};

// of(sum of numerators / sum of denominators) over all, with its jackknife error.
template <typename Of>
Ratio jackknife(const std::vector<double>& numerators, const std::vector<double>& denominators,
                Of of) {
  const double above = std::accumulate(numerators.begin(), numerators.end(), 0.0);
  const double below = std::accumulate(denominators.begin(), denominators.end(), 0.0);
  const double n = static_cast<double>(numerators.size());
  std::vector<double> without;
  for (std::size_t i = 0; i < numerators.size(); ++i)
    without.push_back(of((above - numerators[i]) / (below - denominators[i])));
  const double mean = std::accumulate(without.begin(), without.end(), 0.0) / n;
  double squares = 0;
  for (const double value : without) squares += (value - mean) * (value - mean);
  const Ratio ratio = {of(above / below), std::sqrt((n - 1) / n * squares)};
  if (!std::isfinite(ratio.value) || !std::isfinite(ratio.error))
    throw std::runtime_error("price of streaks: without one of them the truth has no light");
  return ratio;
}

// Rounding may leave a sum of squares below 0 when all but one are 0.
double root(double ratio) {
  return std::sqrt(std::abs(ratio));
}

double median_error(const std::vector<StreakSums>& streaks) {
  std::vector<double> errors;
  for (const StreakSums& streak : streaks) {
    if (streak.truth_light != 0) errors.push_back(std::abs(streak.light / streak.truth_light - 1));
  }
  const auto middle = errors.begin() + (std::ssize(errors) - 1) / 2;
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

// Sums of floats are not exact to more.
std::string median_text(double typical) {
  return typical < 1e-6 ? "below 0.0001 %" : fmt::format("{:.2g} %", 100 * typical);
}

}  // namespace

StreakSums streak_sums(const std::vector<float>& ours, const std::vector<float>& truth) {
  if (ours.size() != truth.size())
    throw std::invalid_argument(
        fmt::format("a streak of {} pixels; expected {}", ours.size(), truth.size()));
  StreakSums sums;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double a = static_cast<double>(ours[i]), t = static_cast<double>(truth[i]);
    sums.squares += (a - t) * (a - t);
    sums.truth_squares += t * t;
    sums.light += a;
    sums.truth_light += t;
  }
  if (!std::isfinite(sums.squares) || !std::isfinite(sums.truth_squares))
    throw std::runtime_error("price of streaks: a pixel that is not finite");
  return sums;
}

Price price_of(const std::vector<StreakSums>& streaks) {
  if (streaks.size() < 2)
    throw std::invalid_argument(fmt::format("{} streaks; expected at least 2", streaks.size()));
  std::vector<double> squares, truth_squares, light_squares, truth_light_squares, light, truth;
  for (const StreakSums& streak : streaks) {
    squares.push_back(streak.squares);
    truth_squares.push_back(streak.truth_squares);
    light.push_back(streak.light);
    truth.push_back(streak.truth_light);
    light_squares.push_back(std::pow(streak.light - streak.truth_light, 2));
    truth_light_squares.push_back(std::pow(streak.truth_light, 2));
  }
  const Ratio picture = jackknife(squares, truth_squares, root);
  const Ratio of_light = jackknife(light_squares, truth_light_squares, root);
  const Ratio sum = jackknife(light, truth, [](double ratio) { return ratio; });
  return {picture.value, picture.error, of_light.value,       of_light.error,
          sum.value,     sum.error,     median_error(streaks)};
}

std::string percent_text(double value, double error) {
  // Two digits of the error, at most four decimals.
  const int decimals =
      error > 0
          ? std::min(4, std::max(0, 1 - static_cast<int>(std::floor(std::log10(100 * error)))))
          : 4;
  return fmt::format("{:.{}f} +- {:.{}f} %", 100 * value, decimals, 100 * error, decimals);
}

Table price_table(const std::string& title, const std::vector<PriceTag>& tags) {
  Table table = {
      .title = title,
      .head = {"approximation", "against", "error of the pictures", "error of the light of streaks",
               "of the median streak", "sum of all light", "cost"}};
  for (const PriceTag& tag : tags) {
    table.rows.push_back(
        {tag.approximation, tag.against, percent_text(tag.price.picture, tag.price.picture_error),
         percent_text(tag.price.light, tag.price.light_error), median_text(tag.price.typical),
         percent_text(tag.price.sum, tag.price.sum_error), tag.cost});
  }
  return table;
}

}  // namespace pluvia
