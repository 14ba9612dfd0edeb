#include "atlas/transfer.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

StreakImage lit_by_environment(const Shard& shard,
                               const std::vector<std::vector<double>>& coefficients) {
  if (coefficients.size() != shard.bands.size()) {
    throw std::invalid_argument(
        fmt::format("{} lists of coefficients; expected one for each of {} "
                    "bands",
                    coefficients.size(), shard.bands.size()));
  }
  const auto count =
      static_cast<std::size_t>(shard.width_px) * static_cast<std::size_t>(shard.height_px);
  StreakImage lit;
  for (std::size_t band = 0; band < coefficients.size(); ++band) {
    const std::vector<double>& c = coefficients[band];
    if (c.empty() || c.size() > shard.transfer.size()) {
      throw std::invalid_argument(
          fmt::format("{} coefficients; expected 1 .. {}, as many as the "
                      "shard has transfer pictures",
                      c.size(), shard.transfer.size()));
    }
    for (std::size_t i = band * count; i < (band + 1) * count; ++i) {
      double mean = 0, deviation = 0;
      for (std::size_t k = 0; k < c.size(); ++k) {
        mean += c[k] * static_cast<double>(shard.transfer[k].mean[i]);
        deviation += std::abs(c[k]) * std::sqrt(static_cast<double>(shard.transfer[k].variance[i]));
      }
      lit.mean.push_back(static_cast<float>(mean));
      lit.variance.push_back(static_cast<float>(deviation * deviation));
    }
  }
  return lit;
}

}  // namespace pluvia
