// Times of settings that are to be compared: repeats are interleaved (first, second, third setting,
// then the first again), so that what else the machine does, and its clock, spread over all of
// them.
#pragma once

#include <functional>
#include <vector>

#include "validate/sweep.h"

namespace pluvia {

// Sets time_s, low_s and high_s to the median, the least and the greatest of at least one time.
void set_times(const std::vector<double>& times_s, SweepPoint& point);

// Runs every job once in each round, on this thread alone (no work of TBB goes to others), and
// gives the processor time of each: [job][round]. rounds >= 1. progress: the share that is done.
std::vector<std::vector<double>> time_interleaved(
    const std::vector<std::function<void(int round)>>& jobs, int rounds,
    const std::function<void(double)>& progress = {});

}  // namespace pluvia
