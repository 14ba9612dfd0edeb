// What the streaks of a picture are like, all together, whichever drops they are: for pictures that
// show other drops, or no known ones.
//
// A ridge point is a pixel of the rain layer (picture minus the same without rain, luminance) that,
// under a Gaussian of 1 pixel, is at least as bright as both neighbours a pixel away across its
// streak. Across and along are the eigenvectors of the structure tensor: products of derivatives
// (of a Gaussian of 1 pixel) under a Gaussian of 3 pixels; its eigenvalues l1 >= l2 are the energy
// of gradients across and along. Bigun and Granlund, "Optimal Orientation Detection of Linear
// Symmetry", ICCV 1987; for rain, Bossu, Hautiere and Tarel, "Rain or Snow Detection in Image
// Sequences Through Use of a Histogram of Orientation of Streaks", IJCV 93, 2011.
//
// Dark streaks, before what is brighter than rain, have no ridge and are not seen. Of streaks
// closer than their width only the brighter has its own. A streak counts by its length.
#pragma once

#include <optional>
#include <vector>

#include "atlas/image.h"
#include "validate/power_spectrum.h"

namespace pluvia {

struct RidgePoint {
  int x_px = 0, y_px = 0;
  double brightness = 0;  // blurred, in the unit of the picture
  double width_px = 0;    // full, at half of that brightness; a line's is 2.355, that of the blur
  double lean_deg = 0;    // of the streak from the vertical, -90 .. 90, positive with its lower end
                          // to the right
  double directed_energy = 0;  // l1 - l2: how much lean_deg counts
};

struct StreakStatistics {
  // Row by row, from pixel 13 from the border, where filters do not reach out of the picture; none
  // where the half lies beyond 32 pixels or the border.
  std::vector<RidgePoint> points = {};
  double coherence = 0;  // sum (l1 - l2) / sum (l1 + l2) over the same pixels: 1 all streaks alike
                         // and straight, 0 no direction anywhere, or nothing at all
  PowerSpectrum spectrum = {};
};

// rain: 1 or 3 channels, at least 16 x 16 pixels. Ridge points of less than least_brightness > 0
// are left out. Throws std::runtime_error for other pictures and values that are not finite.
StreakStatistics streak_statistics(const Image& rain, double least_brightness);

// Earth mover's distances (validate/wasserstein.h) of the ridge points; none where only one of the
// pictures has any (of a direction, for lean_deg), 0 where neither has. sampling: the same between
// the points of the reference that lie in the black and in the white tiles of a board, over sqrt 2:
// what another sample of the same rain would differ by; none where a colour has no points.
struct SampledDistance {
  std::optional<double> value = {}, sampling = {};
};
struct StatisticsDistance {
  SampledDistance brightness = {};  // over the mean brightness of the reference's points
  SampledDistance width_px = {};
  SampledDistance lean_deg = {};  // around the circle of 180 degrees, by directed_energy
  SpectralDistance spectrum = {};
};
StatisticsDistance statistics_distance(const StreakStatistics& a,
                                       const StreakStatistics& reference);

}  // namespace pluvia
