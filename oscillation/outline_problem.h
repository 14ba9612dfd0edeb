// The least-squares problem behind oscillation/outline_fit.h: its parameters, its residuals, and
// the search from many starts. Only that file and its estimates use it.
#pragma once

#include <vector>

#include "oscillation/outline.h"
#include "oscillation/outline_fit.h"

namespace pluvia {

// r0 / start, phi_drop [rad], then a and b of every mode.
using OutlineParameters = std::vector<double>;
constexpr std::size_t first_outline_mode = 2;

// Bound of a and b; the drop's own model ends near 0.3.
constexpr double largest_outline_amplitude = 0.5;

struct OutlineDatum {
  OutlinePoint point = {};
  OutlineRay ray = {};
  double unit_m = 0;  // of the residual
};

struct OutlineTask {
  const OutlineModel& model;
  std::vector<OutlineDatum> data = {};
  double start_m = 0;     // r0 to start from: median of the radii over the resting drop's
  double floor = 0;       // smallest scale of the residuals
  double period_rad = 0;  // of phi_drop; 0: no mode has m > 0
};

// Throws as fit_outlines does.
OutlineTask make_outline_task(const Outlines& outlines, const OutlineModel& model);

struct OutlineSolution {
  OutlineParameters x = {};
  double cost = 0;                     // of the loss, in squared scales
  std::vector<double> residuals = {};  // in units of the data
  bool converged = false;
};

struct OutlineSolutions {
  std::vector<OutlineSolution> found = {};  // best first: those that the data cannot tell apart
  double scale = 0;                         // robust standard deviation of the residuals
  int starts = 0;
};

// The same drop with phi_drop in [0, period), every a and b turned to match; phi_drop 0 where no
// mode has m > 0.
void make_canonical(const OutlineTask& task, OutlineParameters& x);

OutlineSolutions solve_outlines(const OutlineTask& task);

// Of the parameters, in their own units, at a solution.
FitCovariance outline_covariance(const OutlineTask& task, const OutlineSolution& solution,
                                 double scale);

}  // namespace pluvia
