// The picture of the reference tracer, in passes: each is an unbiased picture by itself, drawn
// independently of the others but for how many samples it gives to which drop, which follows from
// the passes before. The picture is their mean; the variance of the mean is
//   sum_k (x_k - mean)^2 / (n (n - 1)),
// without bias also for passes of unequal variance, since they are uncorrelated. Both are functions
// of scene, seed and number of passes alone.
//
// A pixel is the mean over its area and the exposure. Most rays through it miss all drops, so the
// picture is taken apart into what would be there without rain, sampled pixel by pixel, and what
// rain changes, sampled drop by drop:
//   rain(pixel) = sum_drops integral over time, and over the directions toward the drop, of
//                 (L with drops - L without) where this drop is the first thing that is met.
// A sample of a drop is a time, evenly in the part of the exposure in which the drop falls, and a
// direction, evenly in the cone Omega around its reach: its weight in the pixel where it lands is
//   Omega f^2 / cos^3 (angle to the camera's axis) x time / exposure        [px^2]
// over the number of samples. Samples of a drop in a pass are a Kronecker sequence in (time, disc),
// shifted at random. Three quarters of a pass go to drops in proportion to the root mean square of
// what their samples brought so far, one quarter by their size in the picture.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "raytrace/reference_scene.h"

namespace pluvia {

struct ReferenceSettings {
  double error = 0.05;   // relative RMSE of the rain, and of the picture without: then done
  double budget_s = 0;   // no pass is begun after so long; 0: no limit
  int least_passes = 8;  // >= 2
  int most_passes = 100000;
  int surface_samples = 4;    // of a pixel in a pass, a square number
  double samples_per_px = 4;  // of a drop in its first pass, per square pixel that it passes over
  std::uint64_t seed = 1;
};

// Sums over passes, row by row, three channels beside each other.
struct ReferenceSums {
  int width = 0, height = 0;
  int passes = 0;
  std::vector<double> surface = {}, surface_squares = {};
  std::vector<double> rain = {}, rain_squares = {};
  std::vector<double> coverage = {};  // one channel: drops are there, and in sight
  std::vector<double> samples = {};   // one channel: of either kind
  // For each drop: samples so far, and the squares of what each brought.
  std::vector<double> drop_samples = {}, drop_squares = {};
};

ReferenceSums empty_sums(const ReferenceScene& scene);

// The same for any number of threads. Throws std::runtime_error for a value that is not finite.
void add_pass(const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums);

// Of a layer: sqrt(sum of variances / sum of squares of the means, less their variance), over all
// pixels and channels; 0 where the layer is 0 in every pass, infinite while passes < 2.
struct ReferenceErrors {
  double surface = 0, rain = 0;
};
ReferenceErrors estimated_errors(const ReferenceSums& sums);

// Passes until the settings' error or budget is met, or most_passes. after_pass may save the sums.
void trace_reference(
    const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums,
    const std::function<void(const ReferenceSums&, const ReferenceErrors&)>& after_pass = {});

// Mean of a layer over the passes, and the variance of the mean.
struct ReferenceLayer {
  std::vector<double> mean = {}, variance = {};
};
ReferenceLayer layer_of(const std::vector<double>& sums, const std::vector<double>& squares,
                        int passes);

}  // namespace pluvia
