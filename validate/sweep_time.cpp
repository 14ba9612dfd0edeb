#include "validate/sweep_time.h"

#include <algorithm>
#include <cassert>

#include <tbb/global_control.h>

#include "raytrace/process_time.h"
#include "validate/median.h"

namespace pluvia {

void set_times(const std::vector<double>& times_s, SweepPoint& point) {
  assert(!times_s.empty());
  const auto [low, high] = std::minmax_element(times_s.begin(), times_s.end());
  point.time_s = median(times_s);
  point.low_s = *low;
  point.high_s = *high;
}

std::vector<std::vector<double>> time_interleaved(
    const std::vector<std::function<void(int round)>>& jobs, int rounds,
    const std::function<void(double)>& progress) {
  // Threads that wait for work count as processor time.
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<std::vector<double>> times_s(jobs.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t job = 0; job < jobs.size(); ++job) {
      const double start_s = process_cpu_s();
      jobs[job](round);
      times_s[job].push_back(process_cpu_s() - start_s);
      const double done = static_cast<double>(round) +
                          static_cast<double>(job + 1) / static_cast<double>(jobs.size());
      if (progress) progress(done / rounds);
    }
  }
  return times_s;
}

}  // namespace pluvia
