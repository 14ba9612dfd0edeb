// The price of an approximation: how far its streaks are from those without it, over many streaks.
//
//   picture   sqrt(sum_i D_i / sum_i S_i),  D_i = sum over pixels (a - t)^2,  S_i = sum t^2
//   light     the same of the light of each streak, D_i = (A_i - T_i)^2,  S_i = T_i^2,
//             A_i = sum over pixels a,  T_i = sum t
//   sum       sum_i A_i / sum_i T_i
// over the streaks i, so that the bright ones decide; and
//   typical   the median of |A_i - T_i| / T_i (nearest rank; streaks without light left out).
// The standard errors are jackknife estimates
// (Efron and Stein 1981): n times the same with one streak left out at a time,
//   sqrt((n - 1) / n sum_i (e_(i) - mean)^2).
// They tell how far another choice of as many lights would move the price, and hold the noise of
// the tracer besides. Streaks of one drop under many lights are not independent drops.
#pragma once

#include <string>
#include <vector>

#include "validate/report.h"

namespace pluvia {

struct StreakSums {  // of one streak: ours is judged, truth the reference
  double squares = 0, truth_squares = 0;
  double light = 0, truth_light = 0;
};

// Row by row; of the same size, or std::invalid_argument. Throws std::runtime_error for a value
// that is not finite.
StreakSums streak_sums(const std::vector<float>& ours, const std::vector<float>& truth);

struct Price {
  double picture = 0, picture_error = 0;  // relative RMSE, one standard error
  double light = 0, light_error = 0;
  double sum = 1, sum_error = 0;
  double typical = 0;  // no error is told of it
};

// Throws std::invalid_argument for fewer than two streaks, and std::runtime_error where, one left
// out, the truth has no light.
Price price_of(const std::vector<StreakSums>& streaks);

struct PriceTag {
  std::string approximation = {};
  std::string against = {};  // what it is compared with
  Price price = {};
  std::string cost = {};  // what it saves, where that is known
};

// "12.3 +- 0.4 %": shares of 1 as per cent.
std::string percent_text(double value, double error);

// One row for each tag.
Table price_table(const std::string& title, const std::vector<PriceTag>& tags);

}  // namespace pluvia
