// One named statement of the fidelity report: a measured number, what it should be, and how far off is
// allowed, with the reason.
#pragma once

#include <string>
#include <vector>

namespace pluvia {

struct Check {
  std::string name = {};         // stable once published, e.g. "sphere.energy.p2"
  double value = 0;              // the deviation, >= 0
  double bound = 0;              // pass: value <= bound
  double measured = 0;
  double expected = 0;
  double uncertainty = 0;        // one standard error of `measured`, or 0 with the reason in `why`
  std::string unit = {};         // of value and bound
  std::string why = {};          // where the bound and the expected value come from; one or two sentences
};

inline bool passes(const Check& check) { return check.value <= check.bound; }  // NaN fails

}  // namespace pluvia
