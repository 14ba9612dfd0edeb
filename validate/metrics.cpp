#include "validate/metrics.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

double relative_rmse(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels || a.values.empty() ||
      a.values.size() != b.values.size()) {
    throw std::runtime_error(fmt::format(
        "relative_rmse: pictures of {} x {} x {} and {} x {} x {}; expected equal sizes > 0",
        a.width, a.height, a.channels, b.width, b.height, b.channels));
  }
  double squared_difference = 0, squared_reference = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double reference = b.values[i], difference = a.values[i] - reference;
    squared_difference += difference * difference;
    squared_reference += reference * reference;
  }
  if (!std::isfinite(squared_difference) || !std::isfinite(squared_reference)) {
    throw std::runtime_error("relative_rmse: a value is not finite; expected finite pictures");
  }
  if (squared_difference == 0) return 0;
  if (squared_reference == 0) {
    throw std::runtime_error("relative_rmse: the reference is zero everywhere; expected a signal");
  }
  return std::sqrt(squared_difference / squared_reference);
}

}  // namespace pluvia
