#include "validate/batch_judge.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace pluvia {

namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// Means of the products of different vectors, and of the vectors with themselves.
struct Products {
  double different = 0, own = 0;
  std::vector<double> without = {};  // `different` with one vector left out
};

Products products(const std::vector<std::vector<double>>& vectors) {
  std::vector<double> sum(vectors.front().size(), 0.0), own, with_sum;
  for (const auto& v : vectors) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += v[i];
    own.push_back(dot(v, v));
  }
  for (const auto& v : vectors) with_sum.push_back(dot(v, sum));
  const double n = static_cast<double>(vectors.size());
  const double all = dot(sum, sum), all_own = std::accumulate(own.begin(), own.end(), 0.0);
  Products result{.different = (all - all_own) / (n * (n - 1)), .own = all_own / n};
  for (std::size_t k = 0; k < vectors.size(); ++k) {
    const double rest = all - 2 * with_sum[k] + own[k], rest_own = all_own - own[k];
    result.without.push_back((rest - rest_own) / ((n - 1) * (n - 2)));
  }
  return result;
}

}  // namespace

BatchVerdict judge_picture(const std::vector<double>& picture,
                           const std::vector<std::vector<double>>& batches) {
  assert(batches.size() >= 3);
  std::vector<std::vector<double>> differences = batches;
  for (auto& d : differences) {
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = picture[i] - d[i];
  }
  return judge_differences(differences, batches);
}

BatchVerdict judge_differences(const std::vector<std::vector<double>>& differences,
                               const std::vector<std::vector<double>>& batches) {
  assert(batches.size() >= 3 && differences.size() == batches.size());
  const Products error = products(differences), size = products(batches);
  // Sums over batches that share no lit pixel are zero but for rounding.
  const auto dark = [&](double square) { return square <= 1e-12 * size.own; };
  if (dark(size.different) || std::any_of(size.without.begin(), size.without.end(), dark)) {
    return {};
  }
  std::vector<double> without;
  for (std::size_t k = 0; k < batches.size(); ++k) {
    without.push_back(error.without[k] / size.without[k]);
  }
  // The jackknife: (n - 1) / n of the sum of squares is (n - 1)^2 times the variance of the mean.
  const double n = static_cast<double>(batches.size());
  return {.square = error.different / size.different,
          .standard_error = (n - 1) * mean_and_error(without).standard_error,
          .batch_square = (error.own - error.different) / size.different};
}

std::vector<double> row_sums(const std::vector<double>& picture, int width_px) {
  const auto width = static_cast<std::size_t>(width_px);
  std::vector<double> sums(picture.size() / width, 0.0);
  for (std::size_t i = 0; i < sums.size() * width; ++i) sums[i / width] += picture[i];
  return sums;
}

MeanAndError mean_and_error(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  MeanAndError result;
  for (const double v : values) result.mean += v / n;
  double square = 0;
  for (const double v : values) square += (v - result.mean) * (v - result.mean);
  result.standard_error = std::sqrt(square / (n * (n - 1)));
  return result;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace pluvia
