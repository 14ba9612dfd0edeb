#include "validate/wasserstein.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace pluvia {
namespace {

using Samples = std::vector<WeightedSample>;

void normalise(Samples& samples) {
  double sum = 0;
  for (const WeightedSample& s : samples) {
    if (!(s.weight >= 0) || !std::isfinite(s.value)) {
      throw std::runtime_error(fmt::format(
          "wasserstein: a sample {} of weight {}; expected a finite value, a weight >= 0", s.value,
          s.weight));
    }
    sum += s.weight;
  }
  if (!(sum > 0) || !std::isfinite(sum)) {
    throw std::runtime_error(
        fmt::format("wasserstein: {} samples of weight {} in all; expected a finite weight > 0",
                    samples.size(), sum));
  }
  for (WeightedSample& s : samples) s.weight /= sum;
}

struct Step {  // F - G between two neighbouring values
  double height = 0;
  double length = 0;
};

// Steps from the first value to the last.
std::vector<Step> steps_between(Samples a, Samples b) {
  normalise(a), normalise(b);
  for (WeightedSample& s : b) s.weight = -s.weight;
  a.insert(a.end(), b.begin(), b.end());
  // In one order on both sides, so that equal distributions add up to equal sums.
  std::stable_sort(a.begin(), a.end(), [](const WeightedSample& x, const WeightedSample& y) {
    return x.value < y.value || (x.value == y.value && std::abs(x.weight) < std::abs(y.weight));
  });
  std::vector<Step> steps;
  double of_a = 0, of_b = 0;
  for (std::size_t i = 0; i + 1 < a.size(); ++i) {
    (a[i].weight > 0 ? of_a : of_b) += a[i].weight;
    steps.push_back({of_a + of_b, a[i + 1].value - a[i].value});
  }
  return steps;
}

double carried(const std::vector<Step>& steps, double level) {
  double sum = 0;
  for (const Step& step : steps) sum += step.length * std::abs(step.height - level);
  return sum;
}

// The height that half of the length does not exceed.
double median_height(std::vector<Step> steps, double length) {
  std::sort(steps.begin(), steps.end(),
            [](const Step& x, const Step& y) { return x.height < y.height; });
  double below = 0;
  for (const Step& step : steps) {
    below += step.length;
    if (below >= length / 2) return step.height;
  }
  return steps.back().height;
}

void wrap(Samples& samples, double period) {
  for (WeightedSample& s : samples) {
    s.value -= period * std::floor(s.value / period);
    if (s.value >= period) s.value = 0;  // -1e-300 is `period` after rounding
  }
}

}  // namespace

double wasserstein(Samples a, Samples b) {
  return carried(steps_between(std::move(a), std::move(b)), 0);
}

double circular_wasserstein(Samples a, Samples b, double period) {
  if (!(period > 0) || !std::isfinite(period)) {
    throw std::runtime_error(fmt::format("circular_wasserstein: period {}; expected > 0", period));
  }
  wrap(a, period), wrap(b, period);
  std::vector<Step> steps = steps_between(std::move(a), std::move(b));
  double length = 0;
  for (const Step& step : steps) length += step.length;
  // From the last value around to the first: F and G are both 1 there.
  steps.push_back({0, period - length});
  return carried(steps, median_height(steps, period));
}

}  // namespace pluvia
