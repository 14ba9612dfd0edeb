// The picture of the reference tracer, in passes: each is an unbiased picture by itself, drawn
// independently of the others but for where it puts its samples, which follows from the passes
// before. The picture is their mean; the variance of the mean is
//   sum_k (x_k - mean)^2 / (n (n - 1)),
// without bias also for passes of unequal variance, since they are uncorrelated. The first passes
// only learn where samples are needed, and are not counted. Everything is a function of scene, seed
// and number of passes alone.
//
// A pixel is the mean over its area and the exposure. Most rays through it miss all drops, so the
// picture is taken apart into what would be there without rain, sampled pixel by pixel, and what
// rain changes, sampled drop by drop:
//   rain(pixel) = sum_drops integral over time, and over the directions toward the drop, of
//                 (L with drops - L without) where this drop is the first thing that is met.
// A sample of a drop is a time, evenly in the part of the exposure in which the drop falls, and a
// direction, evenly in the cone Omega around its reach: its weight in the pixel where it lands is
//   Omega f^2 / cos^3 (angle to the camera's axis) x time / exposure        [px^2]
// over the number of samples, by strata (raytrace/reference_strata.h).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "raytrace/reference_pass.h"
#include "raytrace/reference_scene.h"

namespace pluvia {

struct ReferenceSettings {
  double error = 0.05;      // relative RMSE of the rain, and of the picture without: then done
  double budget_s = 0;      // no pass is begun after so long; 0: no limit
  int learning_passes = 6;  // >= 1
  int least_passes = 8;     // that count, >= 2
  int most_passes = 100000;
  double surface_samples = 8;  // of a pixel in a pass, on the average
  double samples_per_px = 4;   // of a drop in a pass, per square pixel that it passes over
  std::uint64_t seed = 1;
};

// Sums over the passes that count, row by row, three channels beside each other, and what all
// passes taught.
struct ReferenceSums {
  int width = 0, height = 0;
  int learned = 0;  // passes
  int passes = 0;   // that count
  std::vector<double> surface = {}, surface_squares = {};
  std::vector<double> rain = {}, rain_squares = {};
  std::vector<double> coverage = {};  // one channel: drops are there, and in sight
  std::vector<double> samples = {};   // one channel: of either kind
  // One channel each: of the samples without drops, summed over all passes.
  std::vector<double> luminance = {}, spread = {};
  std::vector<Stratum> strata = {};
};

ReferenceSums empty_sums(const ReferenceScene& scene);

// The same for any number of threads. Throws std::runtime_error for a value that is not finite.
void add_pass(const ReferenceScene& scene, const ReferenceSettings& settings, ReferenceSums& sums);

// min(1, white / L)^2, L the mean luminance of the pixel without drops: where the picture is
// brighter than white a screen shows less of an error, and a lamp of some pixels must not take all
// samples, nor hide in its own brightness that the rain is still noise. Call after the first pass.
std::vector<double> pixel_weights(const ReferenceScene& scene, const ReferenceSums& sums);

// Of a layer: sqrt(sum of variances / sum of squares of the means, less their variance), over all
// channels and pixels, both sums with the pixels' weights; 0 where the layer is the same in every
// pass, infinite while passes < 2.
struct ReferenceErrors {
  double surface = 0, rain = 0;
  double rain_noise = 0;  // the rain's noise over the surfaces' signal: infinite where that is 0
};
ReferenceErrors estimated_errors(const ReferenceScene& scene, const ReferenceSums& sums);

// Whether both layers have that error. Rain that changes nothing, as drops under an even sky, has
// no signal to be held against: it is done where it cannot be told from none (an error of 1 or
// more) and its noise is less than least_rain times the error of the picture without it.
constexpr double least_rain = 0.01;
bool meets(const ReferenceErrors& errors, double error);

// Passes until the settings' error or budget is met, or most_passes. after_pass may save the sums.
using AfterPass = std::function<void(const ReferenceSums&, const ReferenceErrors&)>;
void trace_reference(const ReferenceScene& scene, const ReferenceSettings& settings,
                     ReferenceSums& sums, const AfterPass& after_pass = {});

// Mean of a layer over the passes, and the variance of the mean. passes >= 2.
struct ReferenceLayer {
  std::vector<double> mean = {}, variance = {};
};
ReferenceLayer layer_of(const std::vector<double>& sums, const std::vector<double>& squares,
                        int passes);

}  // namespace pluvia
