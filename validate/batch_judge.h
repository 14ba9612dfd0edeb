// The error of a picture against a truth that is known only from independent noisy pictures of it,
// "batches" b_1 .. b_B of equal noise.
//
// Noise of different batches is independent, so that sums over pixels of (f - b_i)(f - b_j), i !=
// j, have the mean sum (f - truth)^2: no noise has to be subtracted. Averaged over all pairs this
// is the same number as sum ((f - b)^2 - var b) with b the batches' mean and var b its variance as
// estimated from their spread. Likewise sum b_i b_j estimates sum truth^2. Standard errors are
// jackknifed over the batches: pixels need not be independent. On average a jackknife is never too
// small (Efron and Stein, Annals of Statistics 9, 1981); here it is too large by up to
// sqrt(2 (B - 1) / (B - 2)), where the batches' noise dwarfs the picture's error.
#pragma once

#include <vector>

namespace pluvia {

// B >= 3 batches of as many values as `picture`. Squares are relative to sum truth^2.
struct BatchVerdict {
  double square = 0;          // of the picture's relative error; an estimate, so it may be negative
  double standard_error = 0;  // of it
  double batch_square = 0;    // of one batch's own relative error: of all together, divided by B
};

// All zero where the truth is not seen: where sum b_i b_j <= 0, of all batches or with one left
// out.
BatchVerdict judge_picture(const std::vector<double>& picture,
                           const std::vector<std::vector<double>>& batches);

// The same of a picture that is known from batches, too: differences[i] is its batch less the
// truth's batches[i], both of the same random numbers, so that most of the noise is in neither.
BatchVerdict judge_differences(const std::vector<std::vector<double>>& differences,
                               const std::vector<std::vector<double>>& batches);

// Sums over the columns of each row.
std::vector<double> row_sums(const std::vector<double>& picture, int width_px);

// Mean of the values and its standard error; at least two values.
struct MeanAndError {
  double mean = 0, standard_error = 0;
};
MeanAndError mean_and_error(const std::vector<double>& values);

// The value below which that share of the values lies, interpolated; share in 0 .. 1, >= 1 value.
double quantile(std::vector<double> values, double share);

}  // namespace pluvia
