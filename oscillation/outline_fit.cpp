#include "oscillation/outline_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "oscillation/outline_problem.h"

namespace pluvia {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double outlier_at = 4;       // robust standard deviations
constexpr double most_scatter = 0.1;   // of r0: as large as the oscillation itself
constexpr double most_outliers = 0.4;  // share of the points; the median breaks down at 0.5

DropShape drop_of(const OutlineTask& task, const OutlineParameters& x) {
  DropShape drop;
  drop.mean_radius_m = x[0] * task.start_m;
  drop.phi_drop_rad = x[1];
  drop.equilibrium_cos = task.model.equilibrium_cos;
  drop.density_kg_m3 = task.model.density_kg_m3;
  drop.surface_tension_n_m = task.model.surface_tension_n_m;
  for (std::size_t i = 0; i < task.model.modes.size(); ++i) {
    const double a = x[first_outline_mode + 2 * i], b = x[first_outline_mode + 2 * i + 1];
    drop.modes.push_back({.n = task.model.modes[i].n,
                          .m = task.model.modes[i].m,
                          .amplitude = std::hypot(a, b),
                          .phase_rad = std::atan2(b, a)});
  }
  return drop;
}

// "20", "31"; "10_2" where the digits alone would be ambiguous.
std::string mode_label(const OutlineModel::Mode& mode) {
  return fmt::format("{}{}{}", mode.n, mode.n < 10 ? "" : "_", mode.m);
}

// The fit's solution, its covariance, and half of a 95 % interval in standard errors.
struct Certainty {
  const OutlineTask& task;
  const OutlineParameters& x;
  FitCovariance covariance = {};
  int freedom = 1;

  double half_width(std::size_t k) const {
    const auto i = static_cast<Eigen::Index>(k);
    return student_t_95(freedom) * std::sqrt(covariance.matrix(i, i));
  }
  ModePair mode(std::size_t i) const {
    const std::size_t at = first_outline_mode + 2 * i;
    const auto k = static_cast<Eigen::Index>(at);
    return {mode_label(task.model.modes[i]),
            {x[at], x[at + 1]},
            covariance.matrix.block<2, 2>(k, k),
            covariance.free[at] || covariance.free[at + 1]};
  }
  Estimate radius() const {
    const double start_mm = 1e3 * task.start_m;
    if (covariance.free[0]) return undetermined("r0_mm", left_free);
    return bounded_estimate("r0_mm", x[0] * start_mm, half_width(0) * start_mm, 0.5 * start_mm,
                            " mm");
  }
  Estimate direction(bool transverse) const {
    const std::string name = "phi_drop_deg";
    if (task.period_rad == 0) return undetermined(name, "no mode has m > 0");
    if (!transverse) {
      return undetermined(name, "no amplitude of a mode with m > 0 can be told from zero");
    }
    if (covariance.free[1]) return undetermined(name, left_free);
    return bounded_estimate(name, x[1] / degree, half_width(1) / degree,
                            0.25 * task.period_rad / degree, " deg");
  }
};

std::vector<Estimate> estimates_of(const Certainty& certainty) {
  std::vector<Estimate> values = {certainty.radius()};
  bool transverse = false;
  for (std::size_t i = 0; i < certainty.task.model.modes.size(); ++i) {
    const bool differs =
        add_mode_estimates(certainty.mode(i), certainty.freedom, largest_outline_amplitude, values);
    transverse = transverse || (differs && certainty.task.model.modes[i].m > 0);
  }
  values.push_back(certainty.direction(transverse));
  return values;
}

std::string refusal_of(const OutlineFit& fit, double r0_m) {
  const double scatter = 1e-3 * fit.scatter_mm / r0_m;
  if (scatter > most_scatter) {
    return fmt::format(
        "the radii scatter by {:.1f} % of r0 about the best drop; expected at most "
        "{:.0f} %",
        100 * scatter, 100 * most_scatter);
  }
  if (fit.outliers > most_outliers * fit.points) {
    return fmt::format("{} of {} points are outliers; expected at most {:.0f} %", fit.outliers,
                       fit.points, 100 * most_outliers);
  }
  return "";
}

void describe_residuals(const OutlineTask& task, const OutlineSolutions& solutions,
                        OutlineFit& fit) {
  const std::vector<double>& residuals = solutions.found.front().residuals;
  std::vector<double> lengths_m;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    lengths_m.push_back(residuals[k] * task.data[k].unit_m);
    if (std::abs(residuals[k]) > outlier_at * solutions.scale) ++fit.outliers;
  }
  fit.points = static_cast<int>(residuals.size());
  fit.scatter_mm = 1e3 * robust_scale(lengths_m);
  const bool told = task.data.front().point.sigma_m > 0;
  fit.scatter_sigma = told ? robust_scale(residuals) : 0;
}

}  // namespace

OutlineFit fit_outlines(const Outlines& outlines, const OutlineModel& model) {
  const OutlineTask task = make_outline_task(outlines, model);
  const OutlineSolutions solutions = solve_outlines(task);
  const OutlineSolution& best = solutions.found.front();
  OutlineFit fit;
  fit.starts = solutions.starts;
  fit.converged = best.converged;
  fit.drop = drop_of(task, best.x);
  describe_residuals(task, solutions, fit);
  Certainty certainty{task, best.x, outline_covariance(task, best, solutions.scale)};
  certainty.freedom =
      fit.points - static_cast<int>(std::count(certainty.covariance.free.begin(),
                                               certainty.covariance.free.end(), false));
  fit.values = estimates_of(certainty);
  fit.refusal = refusal_of(fit, fit.drop.mean_radius_m);
  if (!fit.refusal.empty()) {
    for (Estimate& value : fit.values) value = undetermined(value.name, fit.refusal);
    return fit;
  }
  const bool every = std::all_of(fit.values.begin(), fit.values.end(), is_identifiable);
  for (std::size_t k = 1; every && k < solutions.found.size(); ++k) {
    fit.alternatives.push_back(drop_of(task, solutions.found[k].x));
  }
  return fit;
}

}  // namespace pluvia
