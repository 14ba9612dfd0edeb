#include "atlas/span_rows.h"

#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

SpanRows span_rows(const ShardRecord& record, double span_s, double t0_s, double exposure_s) {
  if (!(span_s > 0 && t0_s >= 0 && exposure_s > 0 && t0_s + exposure_s <= span_s * (1 + 1e-9))) {
    throw std::invalid_argument(fmt::format(
        "exposure_s = {} from t0_s = {}; expected 0 < exposure_s, 0 <= t0_s, together at most {} s",
        exposure_s, t0_s, span_s));
  }
  const double rows_per_s = (record.path_bottom_row - record.path_top_row) / span_s;
  const double first = record.path_top_row + rows_per_s * t0_s;
  return {
      .first_row = first, .last_row = first + rows_per_s * exposure_s, .gain = span_s / exposure_s};
}

}  // namespace pluvia
