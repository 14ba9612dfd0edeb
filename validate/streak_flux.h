// The light of each streak: the sum of luminance times area over the pixels that the streak
// touches, in a rain layer (picture minus the same without rain). An error that pictures hide,
// because it is spread over a streak, adds up here; one that moves light within a streak is gone.
#pragma once

#include <optional>
#include <vector>

#include "atlas/image.h"
#include "validate/metrics.h"
#include "validate/streak_footprint.h"

namespace pluvia {

struct StreakMask {  // the pixels x0 <= x < x0 + width, y0 <= y < y0 + height that are `touched`
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<bool> touched = {};  // width * height, row by row
};

// Where any value of the footprint is not 0.
StreakMask mask_of(const Footprint& footprint);

struct StreakFlux {  // [unit of the pictures x px^2]
  double measured = 0;
  double truth = 0;           // below 0 where the drop hides more light than it sends
  double standard_error = 0;  // of truth
};

// Where streaks overlap, each has all the light of the common pixels. variance: of every value of
// the truth, independent; none: exact. Throws std::runtime_error as validate/metrics.h does, for a
// mask that leaves the picture, and for a negative variance.
std::vector<StreakFlux> streak_fluxes(const Image& rain, const Image& truth,
                                      const std::vector<StreakMask>& masks,
                                      const std::optional<Image>& variance = {});

struct FluxError {
  NoisyError all = {};         // over the streaks as over pixels: sqrt(sum (m - t)^2 / sum t^2)
  MapSummary of_typical = {};  // |m - t| of a streak over the root mean square of t
};

// Common pixels make the errors of overlapping streaks depend on each other: the standard errors
// are for streaks that lie apart. All 0 where nothing has any light. Throws std::runtime_error
// for no streak, and for light where the truth has none at all.
FluxError flux_error(const std::vector<StreakFlux>& fluxes);

}  // namespace pluvia
