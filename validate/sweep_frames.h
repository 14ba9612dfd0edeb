// What rain costs in a frame, for curves of renderers.
#pragma once

#include "realtime/gl_context.h"
#include "realtime/rain_renderer.h"

namespace pluvia {

// A software rasteriser: its time is processor time, of all threads.
bool on_processor(const GlInfo& info);

// Of the passes that draw streaks, and what streaks see: processor time on a software rasteriser,
// else wall-clock time.
double rain_time_s(const Frame& frame, const GlInfo& info);

}  // namespace pluvia
