// Order statistics: of repeats, whose median one slow frame does not move, and of light.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pluvia {

// Of at least one value; of an even number the upper of the two in the middle.
inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// That one of a thousand exceeds, of at least one value (std::vector or Eigen's).
template <typename Values>
auto exceeded_by_a_thousandth(Values values) {
  const auto place = values.end() - 1 - static_cast<std::ptrdiff_t>(values.size() / 1000);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace pluvia
