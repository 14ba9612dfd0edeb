// How far a true value may be from what it is compared with by chance alone.
//
// A family of N independent comparisons is to raise a false alarm with probability a at most once
// in all of it. By Sidak each may do so with
//   a_1 = 1 - (1 - a)^(1/N),
// and its bound is the quantile of its statistic at that: of a normal one, or of Student's t where
// the standard error itself comes from few replicates (nu = replicates - 1):
//   P(|t| > x) = I_{nu / (nu + x^2)}(nu / 2, 1/2), the regularised incomplete beta function.
// The comparisons need not be independent for N a_1 to be an upper bound (Bonferroni), to 1 + a/2.
#pragma once

#include <string>

namespace pluvia {

// 0 < family < 1, comparisons >= 1: a_1 above.
double each_false_alarm(double family, int comparisons);

// In standard errors; degrees_of_freedom >= 1, or 0 for a normal statistic.
double two_sided_bound(double family, int comparisons, int degrees_of_freedom = 0);
double one_sided_bound(double family, int comparisons);

// Of the whole fidelity report: one report of right pictures in a hundred (were its seeds drawn)
// fails somewhere by chance.
inline constexpr double report_false_alarm = 0.01;
// field.flux and field.picture, gn2006.brute_force.osc6: easy and hard of each.
inline constexpr int report_comparisons = 6;

// One sentence for `why`: "By chance alone ..".
std::string false_alarm_text();

}  // namespace pluvia
