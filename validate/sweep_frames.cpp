#include "validate/sweep_frames.h"

namespace pluvia {

bool on_processor(const GlInfo& info) {
  return info.renderer.find("llvmpipe") != std::string::npos ||
         info.renderer.find("softpipe") != std::string::npos;
}

double rain_time_s(const Frame& frame, const GlInfo& info) {
  double time_s = 0;
  for (const PassCost& pass : frame.costs) {
    const bool of_rain = pass.pass == "rain" || pass.pass == "composite" ||
                         pass.pass == "billboards" || pass.pass == "surroundings";
    if (!of_rain) continue;
    time_s += on_processor(info) ? pass.cpu_s : pass.wall_s;
  }
  return time_s;
}

}  // namespace pluvia
