// What two reports (validate/report.h) say differently.
//
// `value` of a check is its deviation, less is better; `uncertainty` is one standard error of
// `measured`, so that of value is uncertainty times |value / (measured - expected)| (1 where the
// measured is the expected). A check is worse or better where its value moved by more than
//
//   2 hypot(of the first, of the second) + 0.01 bound:
//
// two standard errors of the difference, and a hundredth of what is allowed, because a check
// without uncertainty still moves in its last digits with compiler, processor and driver. A value
// that is no number counts as infinite. Timings, machine and commands are not compared.
#pragma once

#include <string>
#include <vector>

#include "validate/check.h"

namespace pluvia {

// The checks of a report.json of version 1. Throws std::runtime_error: "FILE:LINE:COL: not JSON:
// ..", "FILE: KEY: found; expected" for a key that is missing or of another type, a name that
// comes twice, and a `pass` that is not what value and bound say.
std::vector<Check> read_report_checks(const std::string& file);

enum class Change { fails_now, worse, better, passes_now, appeared, gone };

struct CheckChange {
  Change change = Change::worse;
  Check before = {};  // of `appeared`: empty
  Check after = {};   // of `gone`: empty
  double margin = 0;  // by how much the value may move and be called the same
};

// In the order of Change, then of the reports. A change from pass to fail or back is told whatever
// the margin.
std::vector<CheckChange> report_difference(const std::vector<Check>& before,
                                           const std::vector<Check>& after);

// fails_now or worse.
bool is_regression(const CheckChange& change);

// One line without its end, such as
//   worse      frame.composite  0.0137 -> 0.0161 relative RMSE (margin 0.0002, bound 0.02)
std::string change_line(const CheckChange& change);

}  // namespace pluvia
