// One named statement of the fidelity report: a measured number, what it should be, and how far off
// is allowed, with the reason.
#pragma once

#include <cmath>
#include <string>

namespace pluvia {

struct Check {
  std::string name = {};  // stable once published, e.g. "sphere.energy.p2"
  double value = 0;       // the deviation, >= 0
  double bound = 0;       // pass: value <= bound
  double measured = 0;
  double expected = 0;
  double uncertainty = 0;  // one standard error of `measured`, or 0 with the reason in `why`
  std::string unit = {};   // of value and bound
  std::string why = {};    // where the bound and the expected value come from; one or two sentences
};

// value <= bound, with every number finite and value >= 0: NaN and infinity fail.
inline bool passes(const Check& check) {
  return check.value >= 0 && check.value <= check.bound && std::isfinite(check.bound) &&
         std::isfinite(check.measured) && std::isfinite(check.expected) &&
         std::isfinite(check.uncertainty);
}

}  // namespace pluvia
