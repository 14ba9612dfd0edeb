// A streak under any environment, from its transfer pictures: with the environment's radiance
// L = sum c_lm Y_lm (raytrace/spherical_harmonics.h), in the drop frame, the picture is
// sum c_lm transfer_lm.
#pragma once

#include <vector>

#include "atlas/streak_database.h"

namespace pluvia {

// One list of coefficients for each band, by l^2 + l + m, no longer than shard.transfer: a shorter
// one is a lower degree. The mean is radiance in the coefficients' unit; it may fall below zero
// where an environment of sharp lights is cut off at a low degree, and is left so. The variance
// takes the errors of all transfer pictures as fully correlated, (sum |c| sigma)^2, since they come
// from the same rays: an upper bound. Throws std::invalid_argument for other numbers of lists or
// coefficients.
StreakImage lit_by_environment(const Shard& shard,
                               const std::vector<std::vector<double>>& coefficients);

}  // namespace pluvia
