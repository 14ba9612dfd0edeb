// How the drop of a streak oscillates, from the streak's brightness: A20, A31, phi_drop and, where
// asked for, both phases at shutter-open. Fitted with Ceres against streaks that the generator
// traces anew for every trial.
//
// Single pixels are ragged where glints flash; what is compared is smooth in the parameters. Of
// every streak, at points two standard deviations of the blur apart along the fall: the flux of a
// row, F, blurred along the rows with a Gaussian, and its first moment about the middle column, M.
// A residual is the difference of sqrt(F + e), or of M / sqrt(F + e), e a thousandth of the mean of
// F: bright flashes do not drown the rest.
//
// Many starts: a grid of amplitudes, directions and phases, the best few of it then polished with
// derivatives from central differences. Phases of 0 are those of the 2006 database; with them the
// parameters are A20 (of either sign) and (A31 cos phi_drop, A31 sin phi_drop), phi_drop in (-180,
// 180]; else those of oscillation/outline_fit.h with phi_drop in [0, 180).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "oscillation/mode_estimates.h"
#include "raytrace/preset.h"

namespace pluvia {

struct MeasuredStreak {
  LightDirection light = {};
  std::vector<double> values = {};  // width * height of the request's frame, >= 0
};

struct StreakStart {
  double a20 = 0, phase20_rad = 0;
  double a31 = 0, phase31_rad = 0;
  double phi_drop_rad = 0;
};

struct StreakFitOptions {
  bool free_phases = false;  // false: both 0 at shutter-open
  bool known_level = true;   // false: one unknown factor on all streaks
  std::size_t polished = 3;  // starts that are followed to their minimum, >= 1
  int iterations = 10;       // of that, at most
};

struct StreakFit {
  std::string refusal = {};           // why these are no such drop's streaks; empty when they are
  std::vector<Estimate> values = {};  // A20, (phase20_deg,) A31, (phase31_deg,) phi_drop_deg
  std::vector<StreakStart> alternatives =
      {};               // other minima that these streaks cannot tell from it
  double level = 1;     // the factor: measured over traced
  double residual = 0;  // root mean square, over that of the measured values
  int traced = 0;       // trials
  bool converged = true;
};

// The grid of starts: 51 with phases 0, 128 with free ones.
std::vector<StreakStart> streak_starts(bool free_phases);

// request: of the streaks' view, picture and preset (raytrace/preset.h); its lights and the modes
// of its drop are replaced. progress: share of the starts' grid, then of the polishing, 0 .. 1.
// Throws std::runtime_error for streaks of another size, black or not finite.
StreakFit fit_streak(const StreakRequest& request, const std::vector<MeasuredStreak>& streaks,
                     const std::vector<StreakStart>& starts, const StreakFitOptions& options = {},
                     const std::function<void(double)>& progress = {});

}  // namespace pluvia
