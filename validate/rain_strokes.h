// Single strokes of rain cut out of mattes (validate/rain_mattes.h), upright, as pictures of what
// they cover: each matte is turned until the fall is vertical, opened along the fall (eroded, then
// dilated, by a line: what is shorter goes, and no width is lost), blurred along it, and cut where
// it falls below a threshold. Wang, Lin, Fang, Yang, Yu and Kang, MSR-TR-2006-102; sizes are ours.
//
// A piece is a single stroke where every row of it is one run that rises and falls once, and it is
// at least four times as long as wide; where strokes cross or touch, or the picture's border cuts
// one, the piece is left out.
#pragma once

#include <vector>

#include "atlas/image.h"

namespace pluvia {

struct StrokeSettings {
  int opening_px = 7;    // odd, >= 1: length of the line
  double blur_px = 1.5;  // >= 0: standard deviation of the blur along the fall
  // The threshold, 0 .. 1 of the matte that one pixel in a thousand exceeds, over all frames: the
  // scale of mattes may not be known (validate/rain_mattes.h).
  double least_share = 0.2;
};

struct RainStroke {
  Image matte = {};  // one channel, the fall downward; the stroke and two pixels around it, 0 where
                     // other strokes are
  int frame = 0;     // from 0
  double x_px = 0, y_px = 0;  // its middle (of light), from the frame's upper left corner; a
                              // pixel's middle is at 0.5
  double width_px = 0;        // sum of the picture over the sum of its rows' largest values: 2.507
                              // standard deviations of a Gaussian across
  double length_px = 0;       // rows whose largest value is at least half of the stroke's
  double brightness = 0;      // mean of the largest values of those rows, 0 .. 1
};

// lean_deg: of the fall from the vertical, -90 .. 90, positive with its lower end to the right.
// Strokes by frame, from top left. Throws std::runtime_error "rain_strokes: .." where OpenImageIO
// cannot turn or filter, and for settings out of their ranges.
std::vector<RainStroke> rain_strokes(const std::vector<Image>& mattes, double lean_deg,
                                     const StrokeSettings& settings);

}  // namespace pluvia
