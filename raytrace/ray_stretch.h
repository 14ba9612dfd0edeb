// The part of a ray that lies between planes, in distance from its origin.
#pragma once

#include <algorithm>
#include <limits>

namespace pluvia {

struct RayStretch {  // empty where from >= to
  double from = 0, to = std::numeric_limits<double>::infinity();
};

// Keeps what has a coordinate between low and high; origin: the ray's at distance 0, slope: its
// change with distance.
inline void clip(double origin, double slope, double low, double high, RayStretch& stretch) {
  if (slope == 0) {
    if (!(origin >= low && origin <= high)) stretch.to = -1;
    return;
  }
  const double a = (low - origin) / slope, b = (high - origin) / slope;
  stretch.from = std::max(stretch.from, std::min(a, b));
  stretch.to = std::min(stretch.to, std::max(a, b));
}

}  // namespace pluvia
