#include "validate/false_alarm.h"

#include <cassert>
#include <cmath>

#include <fmt/format.h>
#include <unsupported/Eigen/SpecialFunctions>

namespace pluvia {

namespace {

// P(|statistic| > x).
double tail(double x, int degrees_of_freedom) {
  if (degrees_of_freedom == 0) return std::erfc(x / std::sqrt(2.0));
  const double nu = degrees_of_freedom;
  using One = Eigen::Array<double, 1, 1>;
  return Eigen::betainc(One(nu / 2), One(0.5), One(nu / (nu + x * x)))(0);
}

// The tail falls from 1: the place where it is `share`, to 1e-12 of it.
double tail_place(double share, int degrees_of_freedom) {
  double low = 0, high = 1;
  while (tail(high, degrees_of_freedom) > share) high *= 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (tail(middle, degrees_of_freedom) > share ? low : high) = middle;
  }
  return high;
}

}  // namespace

double each_false_alarm(double family, int comparisons) {
  assert(family > 0 && family < 1 && comparisons >= 1);
  return -std::expm1(std::log1p(-family) / comparisons);
}

double two_sided_bound(double family, int comparisons, int degrees_of_freedom) {
  assert(degrees_of_freedom >= 0);
  return tail_place(each_false_alarm(family, comparisons), degrees_of_freedom);
}

double one_sided_bound(double family, int comparisons) {
  return tail_place(2 * each_false_alarm(family, comparisons), 0);
}

std::string false_alarm_text() {
  return fmt::format(
      "By chance alone {:.2g} of right pictures fail the {} such comparisons of a "
      "report, together.",
      report_false_alarm, report_comparisons);
}

}  // namespace pluvia
