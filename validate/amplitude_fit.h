// The amplitudes A20 and A31 of the ten oscillation sets of the 2006 database, from its real
// factors: fitted on light elevations 10 and 90, judged on 50. phi_drop of every set is the
// preset's.
//
// A factor is the brightest pixel of a streak, and a maximum is ragged. So the logarithms of the
// maxima are tabulated over a grid of (A20, A31) for every phi_drop, as means over several seeds,
// and what Ceres fits is the bicubic surface through the table (automatic derivatives): all sets at
// once, with the one unit that their factors share, under a robust loss, each set from the best
// node of its grid. The fitted drops are then traced anew, with another seed, and it is those
// streaks whose residuals are reported.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "oscillation/estimate.h"
#include "raytrace/preset.h"
#include "validate/real_factors.h"

namespace pluvia {

struct AmplitudeGrid {
  std::vector<double> a20 = {0, 0.05, 0.1, 0.15, 0.2, 0.25};  // equally spaced from 0, two or more
  std::vector<double> a31 = {0, 0.04, 0.08, 0.12};            // likewise
  int seeds = 2;                                              // per node, >= 1
};

struct SetAmplitudes {
  int oscillation = 0;
  double phi_drop_deg = 0;            // held
  std::vector<Estimate> values = {};  // A20, A31
  // Root mean square of log10(ours / theirs) in one unit for all sets; -1 without such factors.
  double rms_fitted = 0;         // elevations 10 and 90
  double rms_judged = 0;         // elevation 50
  double rms_judged_preset = 0;  // .. with the preset's amplitudes, in the best unit for those
};

struct AmplitudeFit {
  std::vector<SetAmplitudes> sets = {};
  double log10_constant = 0;  // the unit: log10(ours / theirs)
  double log10_noise = 0;  // of one entry of the table: standard deviation between seeds; 0 for one
  int traced = 0;
  bool converged = true;
};

// log10 of the brightest pixel of every light's streak.
struct AmplitudeModel {
  std::vector<LightDirection> lights = {};
  std::function<std::vector<double>(double a20, double a31, double phi_drop_deg,
                                    std::uint64_t seed)>
      log_maxima = {};
};

// The lights of the factors, in streaks of the preset's camera elevation 0, traced. log_maxima
// throws std::runtime_error for a streak that is black.
AmplitudeModel traced_model(const Preset& preset, const std::vector<RealFactor>& factors);

// phi_drop is that of the sets, and their amplitudes are what the fit is compared with. progress:
// share done, 0 .. 1. Throws std::runtime_error without factors of elevation 10 or 90 of the sets,
// or where they are too few for what is fitted; every factor's light must be one of the model's.
AmplitudeFit fit_amplitudes(const std::vector<OscillationSet>& sets,
                            const std::vector<RealFactor>& factors, const AmplitudeModel& model,
                            const AmplitudeGrid& grid = {},
                            const std::function<void(double)>& progress = {});

}  // namespace pluvia
