// Rain taken out of a clip: how much of the light of each pixel is rain's, frame by frame, and what
// stands behind the rain. With frames I_k, background S, mattes a_k and rain colours C_k, minimise
//
//   E = sum_k,x,c (I_k - (1 - a_k) S - a_k C_k)^2
//       + lambda sum_x,c |grad S|^2 + mu sum_k,x (grad a_k . D0)^2,   0 <= a_k <= 1,  0 <= S
//
// over x pixels, c channels, D0 the direction of fall. Wang, Lin, Fang, Yang, Yu and Kang,
// "Real-Time Rendering of Realistic Rain", Microsoft Research MSR-TR-2006-102; lambda = 1/20,
// mu = 1/4 and 20 frames are theirs. Mattes and background are found in turn; either is a quadratic
// problem for the other held (validate/matte_systems.h), so E never rises. S begins as the median
// over time, D0 as vertical; after each round of mattes D0 becomes the strongest line through the
// origin of their spectrum, where that makes E no larger.
//
// C_k is unknown too, in each channel of each frame: it begins with the value that one pixel in a
// thousand exceeds, and after each background becomes what makes E least. Only the texture behind
// the rain tells thin bright rain from thicker, darker rain; where that says little, mattes are
// right in shape but their scale is not known.
//
// The camera and what it looks at must stand still, and rain in one frame must be nowhere near
// where it is in the next: what stays is background.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

struct MatteSettings {
  double lambda = 1.0 / 20;  // >= 0
  double mu = 1.0 / 4;       // >= 0
  int iterations = 20;       // >= 1, at most: it ends when a whole one lowers E by less than 0.5 %
  double white = 1;          // > 0, the light that counts as 1: mu weighs mattes against light
};

// E after a step, in units of white^2.
struct MatteEnergy {
  double data = 0, background = 0, mattes = 0;  // the three sums, weighted
  double total() const { return data + background + mattes; }
};

// E after each step of one iteration, in their order.
struct MatteIteration {
  MatteEnergy mattes = {}, direction = {}, background = {}, colours = {};
};

struct RainMattes {
  Image background = {};                            // size and unit of the frames
  std::vector<Image> mattes = {};                   // one channel, 0 .. 1, one for each frame
  std::vector<std::array<double, 3>> colours = {};  // C_k, unit of the frames; as many as channels
  double lean_deg = 0;     // of D0 from the vertical, -90 .. 90, positive with its lower end to the
                           // right
  MatteEnergy start = {};  // E of the median without mattes
  std::vector<MatteIteration> iterations = {};
};

// Of each value by itself; of an even number the mean of the middle two.
// Frames: at least one, all of one size.
Image temporal_median(const std::vector<Image>& frames);

// progress: what, and the share of the iterations. The same bytes for any number of threads.
// Throws std::runtime_error "rain_mattes: what was found; expected .." for less than 3 frames,
// frames of less than 16 x 16 pixels or not all of one size, other than 1 or 3 channels, values
// that are not finite or below 0, and settings out of their ranges.
RainMattes rain_mattes(const std::vector<Image>& frames, const MatteSettings& settings,
                       const std::function<void(const std::string&, double)>& progress);

}  // namespace pluvia
