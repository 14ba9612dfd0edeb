// Distances between pictures.
#pragma once

#include "atlas/image.h"

namespace pluvia {

// sqrt(sum (a - b)^2 / sum b^2) over all pixels and channels, b the reference; 0 where both are
// zero everywhere. Throws std::runtime_error when the sizes differ, when there is no pixel, when a
// value is not finite, and when only the reference is zero everywhere.
double relative_rmse(const Image& a, const Image& b);

}  // namespace pluvia
