// The direction in which rain falls, from its mattes: streaks that lean alike have their power on
// a line through the origin of the spectrum, across the streaks.
#pragma once

#include <optional>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

// Lean from the vertical, -90 .. 90 degrees, positive with the lower end to the right, of the
// strongest line through the origin of the mean power spectrum (validate/power_spectrum.h) of
// pictures of one size and one channel, at least 16 x 16 pixels. Power is summed along lines every
// half degree, from 2 waves in the picture's shorter side to 0.5 cycles per pixel, and the peak of
// a parabola through the sums' logarithms within 4 degrees of the strongest is taken. None where
// the pictures are even, or no line is twice as strong as the mean of all.
std::optional<double> fall_lean_deg(const std::vector<Image>& pictures);

}  // namespace pluvia
