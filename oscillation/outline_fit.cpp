#include "oscillation/outline_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <Eigen/Dense>

#include "oscillation/outline.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

// Cauchy's loss of this width (in standard deviations) keeps 95 % of the precision of least squares
// on normal errors (Holland and Welsch 1977).
constexpr double cauchy_width = 2.3849;
constexpr double outlier_at = 4;           // robust standard deviations
constexpr double most_scatter = 0.1;       // of r0: as large as the oscillation itself
constexpr double most_outliers = 0.4;      // share of the points; the median breaks down at 0.5
constexpr double largest_amplitude = 0.5;  // bound of a and b; the drop's own model ends near 0.3
constexpr double rounding = 1e-12;         // of r0: no scatter is taken to be smaller

// Parameters: r0 / start, phi_drop [rad], then a and b of every mode.
using Parameters = std::vector<double>;
constexpr std::size_t first_mode = 2;

struct Datum {
  OutlinePoint point = {};
  OutlineRay ray = {};
  double unit_m = 0;  // of the residual
};

struct Task {
  const OutlineModel& model;
  std::vector<Datum> data = {};
  double start_m = 0;          // radius of the sphere to start from
  double floor = 0;            // smallest scale of the residuals
  double period_rad = 2 * pi;  // of phi_drop; 0: no mode has m > 0
};

struct Residual {
  const Task* task = nullptr;
  const Datum* datum = nullptr;

  template <typename T>
  HarmonicSurface<T> surface(T const* const* p) const {
    using std::cos, std::sin;
    const OutlineModel& model = task->model;
    HarmonicSurface<T> result;
    result.scale = p[0][0] * task->start_m;
    std::array<double, max_harmonic_degree + 1> one = {1};
    add_harmonic(result, 0, 0, one, T(1), T(0));
    for (std::size_t k = 0; k < model.equilibrium_cos.size(); ++k) {
      const int degree_k = static_cast<int>(k);
      add_harmonic(result, 0, degree_k, chebyshev(degree_k), T(model.equilibrium_cos[k]), T(0));
    }
    for (std::size_t i = 0; i < model.modes.size(); ++i) {
      const auto [n, m] = model.modes[i];
      const T w =
          mode_frequency_rad_s(result.scale, model.density_kg_m3, model.surface_tension_n_m, n);
      const T turn = w * datum->point.time_s;
      const T displacement =
          p[first_mode + 2 * i][0] * sin(turn) + p[first_mode + 2 * i + 1][0] * cos(turn);
      add_mode(result, n, m, displacement, p[1][0]);
    }
    return result;
  }

  // The place of the silhouette is found once, in double; there, by the envelope theorem, the
  // derivative of the distance is that of the surface's.
  template <typename T>
  bool operator()(T const* const* p, T* residual) const {
    const HarmonicSurface<T> here = surface(p);
    const Eigen::Vector3d u = outline_direction(plain(here), datum->ray);
    const Eigen::Matrix<T, 3, 1> direction = u.cast<T>();
    const T distance = here.scale * evaluate(here, direction).h * u.dot(datum->ray.across);
    residual[0] = (distance - datum->point.radius_m) / datum->unit_m;
    return true;
  }

  static double number(double v) { return v; }
  template <typename T>
  static double number(const T& jet) {
    return jet.a;
  }
  template <typename T>
  static HarmonicSurface<double> plain(const HarmonicSurface<T>& from) {
    HarmonicSurface<double> to;
    to.scale = number(from.scale);
    to.order_count = from.order_count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(from.order_count); ++i) {
      to.orders[i].m = from.orders[i].m;
      to.orders[i].degree = from.orders[i].degree;
      for (std::size_t k = 0; k <= static_cast<std::size_t>(from.orders[i].degree); ++k) {
        to.orders[i].a[k] = number(from.orders[i].a[k]);
        to.orders[i].b[k] = number(from.orders[i].b[k]);
      }
    }
    return to;
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void refuse_wrong_model(const OutlineModel& model) {
  for (std::size_t i = 0; i < model.modes.size(); ++i) {
    const auto [n, m] = model.modes[i];
    if (n < 2 || n > max_harmonic_degree || m < 0 || m > n) {
      throw std::invalid_argument(
          fmt::format("mode {},{}; expected 2 <= n <= {}, 0 <= m <= n", n, m, max_harmonic_degree));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (model.modes[j].n != n || model.modes[j].m != m) continue;
      throw std::invalid_argument(fmt::format("mode {},{} twice; expected each once", n, m));
    }
  }
}

Task make_task(const Outlines& outlines, const OutlineModel& model) {
  refuse_wrong_model(model);
  const std::size_t unknowns = 2 + 2 * model.modes.size();
  if (outlines.points.size() <= unknowns) {
    throw std::runtime_error(fmt::format("{} points; expected more than the {} unknowns",
                                         outlines.points.size(), unknowns));
  }
  Task task{model};
  std::vector<double> radii, units;
  for (const OutlinePoint& p : outlines.points) radii.push_back(p.radius_m);
  task.start_m = median(radii);
  for (const OutlinePoint& p : outlines.points) {
    units.push_back(p.sigma_m > 0 ? p.sigma_m : task.start_m);
    task.data.push_back(
        {p, outline_ray(p.view_elevation_rad, p.view_azimuth_rad, p.theta_rad), units.back()});
  }
  task.floor = rounding * task.start_m / median(units);
  int divisor = 0;
  for (const auto& mode : model.modes) divisor = std::gcd(divisor, mode.m);
  task.period_rad = divisor > 0 ? pi / divisor : 0;
  return task;
}

// A problem of its own for every set of parameters.
struct Solver {
  const Task& task;
  Parameters x = {};
  ceres::Problem problem = {};

  Solver(const Task& of, const Parameters& start, double scale) : task(of), x(start) {
    std::vector<double*> blocks = this->blocks();
    for (const Datum& datum : task.data) {
      auto* cost = new ceres::DynamicAutoDiffCostFunction<Residual, 6>(
          new Residual{&task, &datum});  // the problem owns it, and the loss
      for (std::size_t k = 0; k < x.size(); ++k) cost->AddParameterBlock(1);
      cost->SetNumResiduals(1);
      problem.AddResidualBlock(cost, new ceres::CauchyLoss(cauchy_width * scale), blocks);
    }
    problem.SetParameterLowerBound(blocks[0], 0, 0.5);
    problem.SetParameterUpperBound(blocks[0], 0, 2);
    for (std::size_t k = first_mode; k < x.size(); ++k) {
      problem.SetParameterLowerBound(blocks[k], 0, -largest_amplitude);
      problem.SetParameterUpperBound(blocks[k], 0, largest_amplitude);
    }
    if (task.period_rad == 0) problem.SetParameterBlockConstant(blocks[1]);
  }
  std::vector<double*> blocks() {
    std::vector<double*> pointers;
    for (double& value : x) pointers.push_back(&value);
    return pointers;
  }
  std::vector<double> residuals() {
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    std::vector<double> values;
    problem.Evaluate(options, nullptr, &values, nullptr, nullptr);
    return values;
  }
};

struct Candidate {
  Parameters x = {};
  double cost = 0;  // of the loss, in squared scales
  std::vector<double> residuals = {};
  bool converged = false;
};

Candidate solve(const Task& task, const Parameters& start, double scale, int iterations) {
  Solver solver(task, start, scale);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-13;
  options.gradient_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &solver.problem, &summary);
  return {solver.x, 2 * summary.final_cost / (scale * scale), solver.residuals(),
          summary.termination_type == ceres::CONVERGENCE};
}

// phi_drop in its own period and the phases to match.
void make_canonical(const Task& task, Parameters& x) {
  if (task.period_rad == 0) {
    x[1] = 0;
    return;
  }
  const double turns = std::floor(x[1] / task.period_rad);
  x[1] -= turns * task.period_rad;
  for (std::size_t i = 0; i < task.model.modes.size(); ++i) {
    // m (phi_drop - turns pi / g) adds turns m / g half turns to the mode.
    const double half_turns = turns * task.model.modes[i].m * task.period_rad / pi;
    if (std::abs(std::remainder(half_turns, 2)) < 0.5) continue;
    x[first_mode + 2 * i] *= -1;
    x[first_mode + 2 * i + 1] *= -1;
  }
}

// The radius of the sphere to start from may be 3 % off; over the time of the outlines no frequency
// may then be wrong by more than a radian between neighbouring starts (w ~ r0^-1.5).
std::vector<double> radius_starts(const Task& task) {
  constexpr double uncertainty = 0.03;
  constexpr int most = 16;
  double first = task.data.front().point.time_s, last = first;
  for (const Datum& datum : task.data) {
    first = std::min(first, datum.point.time_s);
    last = std::max(last, datum.point.time_s);
  }
  double fastest = 0;
  for (const auto& mode : task.model.modes) {
    fastest = std::max(fastest, mode_frequency_rad_s(task.start_m, task.model.density_kg_m3,
                                                     task.model.surface_tension_n_m, mode.n));
  }
  const double turn = 1.5 * uncertainty * fastest * (last - first);
  const int count = static_cast<int>(std::clamp(std::ceil(turn), 1.0, static_cast<double>(most)));
  std::vector<double> starts;
  for (int k = -count; k <= count; ++k) starts.push_back(1 + uncertainty * k / count);
  return starts;
}

std::vector<Parameters> all_starts(const Task& task) {
  constexpr int directions = 4;  // of phi_drop in its period, none at an axis of symmetry
  constexpr double amplitude = 0.03;
  std::vector<Parameters> starts;
  for (const double radius : radius_starts(task)) {
    for (int k = 0; k < (task.period_rad > 0 ? directions : 1); ++k) {
      Parameters x(first_mode + 2 * task.model.modes.size(), amplitude);
      x[0] = radius;
      x[1] = task.period_rad * (k + 0.3) / directions;
      starts.push_back(x);
    }
  }
  return starts;
}

bool same(const Parameters& a, const Parameters& b, double period_rad) {
  constexpr double tolerance = 1e-4;
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double difference = a[k] - b[k];
    worst = std::max(
        worst,
        std::abs(k == 1 && period_rad > 0 ? std::remainder(difference, period_rad) : difference));
  }
  return worst < tolerance;
}

// Solves from every start; best first, each solution once. Costs above the best's by `margin` are
// dropped.
std::vector<Candidate> solve_all(const Task& task, const std::vector<Parameters>& starts,
                                 double scale, int iterations, double margin) {
  std::vector<Candidate> found;
  for (const Parameters& start : starts) {
    found.push_back(solve(task, start, scale, iterations));
    make_canonical(task, found.back().x);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<Candidate> kept;
  for (Candidate& candidate : found) {
    if (candidate.cost > found.front().cost + margin) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const Candidate& other) {
          return same(candidate.x, other.x, task.period_rad);
        })) {
      kept.push_back(std::move(candidate));
    }
  }
  return kept;
}

struct Solutions {
  std::vector<Candidate> found = {};  // best first
  double scale = 0;
  int starts = 0;
};

// The loss's width follows the median of the residuals, which follows the fit: a few rounds.
Solutions solve_robustly(const Task& task) {
  constexpr double alternative = 3.84;  // of cost: 95 % of chi-square with one degree of freedom
  const std::vector<Parameters> starts = all_starts(task);
  const auto scale_of = [&](const std::vector<double>& residuals) {
    return std::max(task.floor, robust_scale(residuals));
  };
  Parameters sphere(starts.front().size(), 0.0);
  sphere[0] = 1;
  Solutions solutions;
  solutions.starts = static_cast<int>(starts.size());
  solutions.scale = scale_of(Solver(task, sphere, 1).residuals());
  const double loose = 0.5 * static_cast<double>(task.data.size());
  solutions.found = solve_all(task, starts, solutions.scale, 15, loose);
  for (int round = 0; round < 12; ++round) {
    const double scale = scale_of(solutions.found.front().residuals);
    const bool settled = std::abs(scale - solutions.scale) <= 0.01 * scale;
    solutions.scale = scale;
    std::vector<Parameters> again;
    for (const Candidate& candidate : solutions.found) again.push_back(candidate.x);
    solutions.found = solve_all(task, again, scale, 50, settled ? alternative : loose);
    if (settled) break;
  }
  return solutions;
}

// "20", "31"; "10_2" where the digits alone would be ambiguous.
std::string mode_name(const OutlineModel::Mode& mode) {
  return fmt::format("{}{}{}", mode.n, mode.n < 10 ? "" : "_", mode.m);
}

DropShape drop_of(const Task& task, const Parameters& x) {
  DropShape drop;
  drop.mean_radius_m = x[0] * task.start_m;
  drop.phi_drop_rad = x[1];
  drop.equilibrium_cos = task.model.equilibrium_cos;
  drop.density_kg_m3 = task.model.density_kg_m3;
  drop.surface_tension_n_m = task.model.surface_tension_n_m;
  for (std::size_t i = 0; i < task.model.modes.size(); ++i) {
    const double a = x[first_mode + 2 * i], b = x[first_mode + 2 * i + 1];
    drop.modes.push_back({.n = task.model.modes[i].n,
                          .m = task.model.modes[i].m,
                          .amplitude = std::hypot(a, b),
                          .phase_rad = std::atan2(b, a)});
  }
  return drop;
}

// The covariance of the solution and what follows from it.
struct Uncertainty {
  FitCovariance covariance = {};
  int freedom = 1;
  double t = 0;  // half of a 95 % interval in standard errors

  double half_width(std::size_t k) const {
    const auto i = static_cast<Eigen::Index>(k);
    return t * std::sqrt(covariance.matrix(i, i));
  }
};

Uncertainty uncertainty_of(const Task& task, const Candidate& best, double scale) {
  Solver solver(task, best.x, scale);
  Uncertainty u;
  u.covariance = fit_covariance(solver.problem, solver.blocks());
  if (task.period_rad == 0) u.covariance.free[1] = true;
  const auto used = static_cast<std::size_t>(
      std::count(u.covariance.free.begin(), u.covariance.free.end(), false));
  u.freedom = static_cast<int>(task.data.size() - used);
  u.t = student_t_95(u.freedom);
  const double variance = cauchy_variance(best.residuals, cauchy_width * scale, used);
  u.covariance.matrix *= std::max(variance, task.floor * task.floor);
  return u;
}

constexpr const char* left_free = "the outlines leave it free";

Estimate undetermined(const std::string& name, const std::string& why) {
  return {.name = name, .why = why};
}

Estimate interval(const std::string& name, double value, double half_width, double widest,
                  const std::string& unit) {
  if (half_width <= widest) return {name, "", value, value - half_width, value + half_width};
  return undetermined(name, fmt::format("its 95 % interval would be +-{:.2g}{}", half_width, unit));
}

// Amplitude and phase of mode i; true when the amplitude differs from zero.
bool add_mode_estimates(const Task& task, const Candidate& best, const Uncertainty& u,
                        std::size_t i, std::vector<Estimate>& values) {
  const std::string amplitude = fmt::format("A{}", mode_name(task.model.modes[i]));
  const std::string phase = fmt::format("phase{}_deg", mode_name(task.model.modes[i]));
  const std::size_t at = first_mode + 2 * i;
  if (u.covariance.free[at] || u.covariance.free[at + 1]) {
    values.push_back(undetermined(amplitude, left_free));
    values.push_back(undetermined(phase, left_free));
    return false;
  }
  const Eigen::Vector2d ab = {best.x[at], best.x[at + 1]};
  const auto k = static_cast<Eigen::Index>(at);
  const Eigen::Matrix2d c = u.covariance.matrix.block<2, 2>(k, k);
  const double size = ab.norm();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(c);
  const bool differs = ab.dot(c.ldlt().solve(ab)) > pair_threshold_95(u.freedom);
  if (!differs) {
    const double half = u.t * std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
    Estimate estimate = interval(amplitude, size, half, largest_amplitude, "");
    estimate.low = 0;
    values.push_back(estimate);
    values.push_back(undetermined(phase, "the amplitude cannot be told from zero"));
    return false;
  }
  const Eigen::Vector2d along = ab / size, across = {-along[1], along[0]};
  Estimate estimate =
      interval(amplitude, size, u.t * std::sqrt(along.dot(c * along)), largest_amplitude, "");
  estimate.low = std::max(0.0, estimate.low);
  values.push_back(estimate);
  values.push_back(interval(phase, std::atan2(ab[1], ab[0]) / degree,
                            u.t * std::sqrt(across.dot(c * across)) / size / degree, 90, " deg"));
  return true;
}

Estimate direction_estimate(const Task& task, const Candidate& best, const Uncertainty& u,
                            bool transverse) {
  const std::string name = "phi_drop_deg";
  if (task.period_rad == 0) return undetermined(name, "no mode has m > 0");
  if (!transverse) {
    return undetermined(name, "no amplitude of a mode with m > 0 can be told from zero");
  }
  if (u.covariance.free[1]) return undetermined(name, left_free);
  return interval(name, best.x[1] / degree, u.half_width(1) / degree,
                  0.25 * task.period_rad / degree, " deg");
}

std::vector<Estimate> estimates_of(const Task& task, const Candidate& best, const Uncertainty& u) {
  std::vector<Estimate> values;
  const double start_mm = 1e3 * task.start_m;
  values.push_back(u.covariance.free[0]
                       ? undetermined("r0_mm", left_free)
                       : interval("r0_mm", best.x[0] * start_mm, u.half_width(0) * start_mm,
                                  0.5 * start_mm, " mm"));
  bool transverse = false;
  for (std::size_t i = 0; i < task.model.modes.size(); ++i) {
    const bool differs = add_mode_estimates(task, best, u, i, values);
    transverse = transverse || (differs && task.model.modes[i].m > 0);
  }
  values.push_back(direction_estimate(task, best, u, transverse));
  return values;
}

std::string refusal_of(const OutlineFit& fit, double r0_m) {
  if (fit.scatter_mm > 1e3 * most_scatter * r0_m) {
    return fmt::format(
        "the radii scatter by {:.1f} % of r0 about the best drop; expected at most "
        "{:.0f} %",
        0.1 * fit.scatter_mm / r0_m, 100 * most_scatter);
  }
  if (fit.outliers > most_outliers * fit.points) {
    return fmt::format("{} of {} points are outliers; expected at most {:.0f} %", fit.outliers,
                       fit.points, 100 * most_outliers);
  }
  return "";
}

void describe_residuals(const Task& task, const Solutions& solutions, OutlineFit& fit) {
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
  const Task task = make_task(outlines, model);
  const Solutions solutions = solve_robustly(task);
  const Candidate& best = solutions.found.front();
  OutlineFit fit;
  fit.starts = solutions.starts;
  fit.converged = best.converged;
  fit.drop = drop_of(task, best.x);
  describe_residuals(task, solutions, fit);
  fit.values = estimates_of(task, best, uncertainty_of(task, best, solutions.scale));
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

const Estimate& estimate_of(const std::vector<Estimate>& values, const std::string& name) {
  const auto at =
      std::find_if(values.begin(), values.end(), [&](const Estimate& e) { return e.name == name; });
  if (at == values.end()) throw std::out_of_range("no estimate of " + name);
  return *at;
}

}  // namespace pluvia
