// All that is measured between a picture of rain and what it should be, in one call.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "validate/flip.h"
#include "validate/metrics.h"
#include "validate/ssim.h"
#include "validate/streak_flux.h"
#include "validate/streak_statistics.h"

namespace pluvia {

struct ComparedPictures {  // of one size, RGB, linear, >= 0, of one unit
  Image picture = {};
  Image reference = {};
  Image dry = {};                        // the same without rain: picture - dry is the rain layer
  double white = 1;                      // what a screen shows as white, > 0
  std::optional<Image> variance = {};    // of every value of the reference; none: it is exact
  std::vector<StreakMask> streaks = {};  // those whose light is compared
};

struct PictureComparison {
  NoisyError rain = {};  // of the rain layers
  Image rain_map = {};   // |difference of luminance|
  MapSummary rain_error = {};
  PeakError ldr = {};  // of srgb_of(.., white), peak 1
  PeakError hdr = {};  // peak: the reference's largest value
  double hdr_peak = 0;
  Ssim ssim = {};           // of srgb_of(.., white)
  FlipError ldr_flip = {};  // of cut_to_screen(.., white)
  MapSummary ldr_flip_map = {};
  std::optional<HdrFlipError> hdr_flip = {};  // none, and then why: the reference is too dark
  MapSummary hdr_flip_map = {};
  std::string no_hdr_flip = {};
  std::optional<FluxError> flux = {};  // none without streaks
  // Of the rain layers; ridge points from the least that a screen of 8 bits shows: 1 / (255 12.92)
  // of white.
  StatisticsDistance statistics = {};
};

// with - without.
Image rain_layer(const Image& with, const Image& without);

// Throws std::runtime_error where the parts do: sizes that differ, values that are not finite or
// negative, pictures of less than 16 x 16 pixels, and a reference without rain.
PictureComparison compare_pictures(const ComparedPictures& pictures);

// The reference as a screen of 8 bits shows it, as a picture: rounded to 255ths of sRGB, made
// linear again. Its distance from the reference is what nobody sees.
Image rounded_to_bytes(const Image& image, double white);

}  // namespace pluvia
