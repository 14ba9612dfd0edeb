// A picture that covers a longer span of time than an exposure: which of its rows are a streak.
//
// The drop's centre passes the rows of its path at a constant rate, so an exposure [t0, t0 +
// exposure] within the span is a stretch of rows. Pixels are averages over the whole span; over the
// exposure alone they are span / exposure times as bright. Where a streak begins and ends the rows
// still hold light of the drop just before and after: half the drop's height is smeared, which is
// all of it where the path is shorter than the drop (steep views, short exposures).
#pragma once

#include "atlas/streak_database.h"

namespace pluvia {

struct SpanRows {
  double first_row = 0;  // of the centre at t0 and at t0 + exposure
  double last_row = 0;
  double gain = 1;  // on the pixels
};

// Throws std::invalid_argument unless 0 <= t0, 0 < exposure and t0 + exposure <= span, to 1e-9 of
// the span.
SpanRows span_rows(const ShardRecord& record, double span_s, double t0_s, double exposure_s);

}  // namespace pluvia
