// How a drop oscillates, from its measured outlines: r0, amplitude and phase of every mode, and
// phi_drop, fitted with Ceres.
//
// The model is the drop of oscillation/drop_shape.h, h = 1 + equilibrium + sum_i (a_i sin(w_i t) +
// b_i cos(w_i t)) P_{n_i,m_i} cos(m_i (phi - phi_drop)), amplitude A = hypot(a, b) and phase p =
// atan2(b, a): linear in what is fitted, so no phase wraps around. w_i follows from r0 (Rayleigh).
// A residual is the true silhouette (oscillation/outline.h) minus the measured radius; automatic
// derivatives; Cauchy's loss of a width that follows from the median of the residuals; many starts
// in r0 (a wrong one is a wrong frequency) and phi_drop. Neither volume nor centroid is kept: the
// measured radii are distances from the star centre of that formula.
//
// The same drop can be written in more than one way: phi_drop + pi / g, g the greatest common
// divisor of the orders m > 0, with every phase of odd m / g half a turn on. Given is phi_drop in
// [0, pi / g) and A >= 0.
#pragma once

#include <string>
#include <vector>

#include "oscillation/drop_shape.h"
#include "oscillation/mode_estimates.h"
#include "oscillation/outline_table.h"

namespace pluvia {

struct OutlineModel {
  struct Mode {
    int n = 2, m = 0;  // 2 <= n <= 10, 0 <= m <= n
  };
  std::vector<Mode> modes = {{2, 0}, {3, 1}};  // each pair once
  std::vector<double> equilibrium_cos = {};    // c_0 .. c_10, held; empty: a sphere
  double density_kg_m3 = 998.2;
  double surface_tension_n_m = 0.0728;
};

struct OutlineFit {
  // Why the outlines are those of no such drop; empty when they are. Else `values` say so too.
  std::string refusal = {};
  std::vector<Estimate> values = {};  // r0_mm, A20, phase20_deg, .., phi_drop_deg
  DropShape drop = {};  // of the values; what is not identifiable is as the fit left it
  std::vector<DropShape> alternatives = {};  // other drops that these outlines cannot tell from it
  double scatter_mm = 0;                     // robust standard deviation of the residuals
  double scatter_sigma = 0;                  // the same in units of the table's sigma; 0 without
  int points = 0, outliers = 0;              // outliers: beyond 4 robust standard deviations
  int starts = 0;
  bool converged = true;
};

// Throws std::runtime_error for fewer points than parameters, std::invalid_argument for modes out
// of range or given twice.
OutlineFit fit_outlines(const Outlines& outlines, const OutlineModel& model = {});

}  // namespace pluvia
