// The benchmarks' figure of repeats: one slow frame does not move it.
#pragma once

#include <algorithm>
#include <vector>

namespace pluvia {

// Of at least one value; of an even number the upper of the two in the middle.
inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace pluvia
