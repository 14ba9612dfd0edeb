// Distances between pictures, pixel by pixel. a is the picture that is judged, b the reference.
// Every function throws std::runtime_error, one line, when the sizes differ, when there is no
// pixel and when a value is not finite.
#pragma once

#include <optional>

#include "atlas/image.h"

namespace pluvia {

// sqrt(sum (a - b)^2 / sum b^2) over all pixels and channels; 0 where both are zero everywhere.
// Throws std::runtime_error also when only the reference is zero everywhere.
double relative_rmse(const Image& a, const Image& b);

// The same where b is known up to noise only: b = t + n, n independent in every value, Gaussian,
// of mean 0 and known variance v. With d = a - t,
//   E sum (a - b)^2 = sum d^2 + sum v,   E sum b^2 = sum t^2 + sum v,
// so that D = sum (a - b)^2 - sum v and S = sum b^2 - sum v have no bias, and
//   Var D    = sum (4 d^2 v + 2 v^2)      estimated by sum (4 (a - b)^2 v - 2 v^2)
//   Var S    = sum (4 t^2 v + 2 v^2)                   sum (4 b^2 v - 2 v^2)
//   Cov(D,S) = sum (-4 d t v + 2 v^2)                  sum (-4 (a - b) b v - 2 v^2).
// The ratio's error is that of first order; an estimate of Var D below its least possible value,
// sum 2 v^2, is replaced by that.
struct NoisyError {
  double relative_rmse = 0;   // with the noise in it, as measured
  double squared = 0;         // D / S: the square without it; below 0 by chance
  double standard_error = 0;  // of squared
  double noise = 0;           // sqrt(sum v / S): the relative RMSE of a perfect picture
  // D <= 2 sqrt(sum 2 v^2): a perfect picture is called that 43 times in 44.
  bool below_noise = false;
};

// variance: v, of the same size as b, >= 0. All 0 where a and b are
// zero everywhere. Throws std::runtime_error also when else S <= 0: no signal above the noise.
NoisyError noisy_error(const Image& a, const Image& b, const Image& variance);

// sqrt(mean (a - b)^2) / peak, peak > 0, and the same as PSNR = -20 log10 of it [dB]: none where
// the pictures are equal.
struct PeakError {
  double rms_over_peak = 0;
  std::optional<double> psnr_db = {};
};
PeakError peak_error(const Image& a, const Image& b, double peak);

// As a screen shows it, before the rounding to bytes: the value over `white` > 0, cut to 0 .. 1.
Image cut_to_screen(const Image& image, double white);
// The same, sRGB-encoded: the curve of write_png (atlas/image_io.h).
Image srgb_of(const Image& image, double white);

// |luminance of a - luminance of b|, one channel.
Image luminance_error(const Image& a, const Image& b);

// Over all values of a map; percentiles are of nearest rank: the least value that so many per cent
// do not exceed.
struct MapSummary {
  double mean = 0, median = 0, percentile_90 = 0, percentile_99 = 0, largest = 0;
};
MapSummary summary_of(const Image& map);

}  // namespace pluvia
