// How far one distribution must be carried to become another (earth mover's distance): exact, from
// weighted samples, with no histogram between.
//
//   W1 = int |F(x) - G(x)| dx                          on a line,
//   W1 = min over c of int |F(x) - G(x) - c| dx        on a circle,
//
// F, G the cumulative shares of weight; the best c is the median of F - G over the circle. Rabin,
// Delon and Gousseau, "Transportation Distances on the Circle", J. Math. Imaging and Vision 41,
// 2011. In the unit of the values; symmetric; 0 between equal distributions.
#pragma once

#include <vector>

namespace pluvia {

struct WeightedSample {
  double value = 0;
  double weight = 1;  // >= 0
};

// Each throws std::runtime_error when one side has no weight in all (no distribution), for a value
// or weight that is not finite, and for a negative weight.
double wasserstein(std::vector<WeightedSample> a, std::vector<WeightedSample> b);

// Values are taken modulo `period` > 0; the distance is at most half of it.
double circular_wasserstein(std::vector<WeightedSample> a, std::vector<WeightedSample> b,
                            double period);

}  // namespace pluvia
