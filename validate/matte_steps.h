// The steps of validate/rain_mattes.h, each of which lowers E or leaves it: the unknowns other than
// its own are held.
#pragma once

#include <array>
#include <vector>

#include "validate/matte_systems.h"
#include "validate/rain_mattes.h"

namespace pluvia {

using PixelValues = Eigen::VectorXd;  // one for each pixel, row by row

struct MatteClip {  // in units of white
  int width = 0, height = 0;
  std::vector<std::vector<PixelValues>> light = {};  // [frame][channel], >= 0
  double brightest = 0;                              // of all of it
};

struct MatteUnknowns {
  std::vector<PixelValues> mattes = {};          // [frame], 0 .. 1
  std::vector<PixelValues> background = {};      // [channel], 0 .. brightest
  std::vector<std::array<double, 3>> rain = {};  // C_k, 0 .. 10 brightest
  double lean_deg = 0;                           // of D0
};

// The quadratic forms that hang on neither light nor mattes.
struct MatteSystems {
  SparseMatrix gradient = {}, fall = {};  // fall: for the unknown lean_deg
};

MatteEnergy matte_energy(const MatteClip& clip, const MatteSystems& systems,
                         const MatteUnknowns& unknowns, const MatteSettings& settings);

void improve_mattes(const MatteClip& clip, const MatteSystems& systems,
                    const MatteSettings& settings, MatteUnknowns& unknowns);

// To the strongest line of the mattes' spectrum, where that does not raise E.
void improve_direction(const MatteClip& clip, const MatteSettings& settings, MatteSystems& systems,
                       MatteUnknowns& unknowns);

void improve_background(const MatteClip& clip, const MatteSystems& systems,
                        const MatteSettings& settings, MatteUnknowns& unknowns);

// Exactly, channel by channel; a frame without rain keeps its colour.
void improve_colours(const MatteClip& clip, MatteUnknowns& unknowns);

// One channel for each of the values, times white.
Image picture_of(const std::vector<PixelValues>& channels, int width, int height, double white);

}  // namespace pluvia
