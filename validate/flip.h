// FLIP: how different two pictures look to a person who flips between them.
//
//   error = color^(1 - feature) in 0 .. 1, 0 where the pictures are equal
//
// color: both pictures, blurred as the eye blurs luminance, red-green and blue-yellow at this many
// pixels a degree, in Hunt-adjusted L*a*b*; their distance |dL| + |(da, db)|, to the power 0.7,
// over that of pure green and blue, redistributed so that 0.4 of it is 0.95.
// feature: sqrt(max(|difference of edges|, |difference of points|) / sqrt(2)), of luminance,
// by first and second derivatives of a Gaussian.
// Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild, "FLIP: A Difference
// Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020.
//
// HDR-FLIP is the largest FLIP of each pixel over exposures about a stop apart, tone-mapped, from
// the one at which the reference's brightest pixel is at 0.85 to that at which its median is:
// Andersson, Nilsson, Shirley and Akenine-Moller, "Visualizing and Communicating Errors in Rendered
// Images", Ray Tracing Gems II, 2021; its tone mapper is the ACES fit.
//
// Pictures: three channels, linear Rec.709, equal sizes > 0. Beyond the border a picture continues
// with its border pixels, as in the papers. Pure functions.
// Throws std::runtime_error for what has no answer: one line, what was found and what was expected.
#pragma once

#include <optional>

#include "atlas/image.h"

namespace pluvia {

struct FlipOptions {
  // Of visual angle, 1 .. 1000. As published: 3840 pixels on 0.7 m, seen from 0.7 m.
  double pixels_per_degree = 3840 * 3.14159265358979323846 / 180;
};

struct HdrFlipOptions {
  FlipOptions flip = {};
  std::optional<double> start_exposure_stops = {};  // none: from the reference
  std::optional<double> stop_exposure_stops = {};   // >= start
};

// A weighted percentile p is the error that pixels of at most that error share p of the sum of all
// errors with: the small errors of the many do not hide the large ones of the few.
struct FlipError {
  Image map = {};  // one channel, 0 .. 1, row 0 at the top
  double mean = 0;
  double least = 0;
  double largest = 0;
  double weighted_first_quartile = 0;
  double weighted_median = 0;
  double weighted_third_quartile = 0;
};

struct HdrFlipError {
  FlipError error = {};
  double start_exposure_stops = 0;  // pictures are multiplied by 2^stops
  double stop_exposure_stops = 0;
  int exposures = 0;  // evenly from start to stop: max(2, ceil(stop - start))
};

// Values 0 .. 1. Symmetric in its pictures.
FlipError ldr_flip(const Image& reference, const Image& test, const FlipOptions& options = {});

// Values >= 0. Only the exposures hang on which picture is the reference; without given ones its
// median luminance must be > 0 (of an even count of pixels, the lower of the two in the middle).
HdrFlipError hdr_flip(const Image& reference, const Image& test,
                      const HdrFlipOptions& options = {});

}  // namespace pluvia
