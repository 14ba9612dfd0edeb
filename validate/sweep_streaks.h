// How far streak pictures are from a truth that is known from several finer runs of other seeds:
// the measure of `pluvia generate --error`, 90th percentile over lights of the relative RMSE of a
// picture, free of the finer runs' noise (validate/batch_judge.h).
#pragma once

#include <vector>

#include "raytrace/streak_tracer.h"
#include "validate/sweep.h"

namespace pluvia {

// One picture as several finer runs have it, at least three.
using PictureBatches = std::vector<std::vector<double>>;

std::vector<double> pixels_of(const StreakImage& image);

// The first share of the exposure, 0 .. 1: as many rows, slices and moments of each mode as that is
// of the whole; without environment.
StreakRequest part_of(StreakRequest request, double share);

constexpr int truth_runs = 3;  // the fewest that tell an error from their own noise

// [light] of runs with seeds beyond the request's, in parallel.
std::vector<PictureBatches> trace_truth(const StreakRequest& request);

// The squared relative error of a picture, its standard error, and the part that is its own noise.
struct JudgedPicture {
  double square = 0, standard_error = 0, noise_square = 0;
};
JudgedPicture judged(const StreakImage& image, const PictureBatches& truth);

// Sets error, standard_error and noise to the roots of the 90th percentiles (nearest rank): the
// standard error is that of the picture of that rank, and the noise the 90th percentile of noises.
// An error that the truth cannot tell from none, its square within a standard error of zero, is
// told as a bound: the root of that standard error above its square, or above zero, with as large a
// standard error. At least one picture.
void set_error(const std::vector<JudgedPicture>& pictures, SweepPoint& point);

}  // namespace pluvia
