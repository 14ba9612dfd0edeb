#include "oscillation/outline_problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include <ceres/ceres.h>
#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;

// Cauchy's loss of this width (in standard deviations) keeps 95 % of the precision of least squares
// on normal errors (Holland and Welsch 1977).
constexpr double cauchy_width = 2.3849;
constexpr double rounding = 1e-12;  // of r0: no scatter is taken to be smaller

// 1 + the equilibrium terms.
template <typename T>
void add_resting_shape(HarmonicSurface<T>& surface, const OutlineModel& model) {
  std::array<double, max_harmonic_degree + 1> one = {1};
  add_harmonic(surface, 0, 0, one, T(1), T(0));
  for (std::size_t k = 0; k < model.equilibrium_cos.size(); ++k) {
    const int degree = static_cast<int>(k);
    add_harmonic(surface, 0, degree, chebyshev(degree), T(model.equilibrium_cos[k]), T(0));
  }
}

struct Residual {
  const OutlineTask* task = nullptr;
  const OutlineDatum* datum = nullptr;

  template <typename T>
  HarmonicSurface<T> surface(T const* const* p) const {
    using std::cos, std::sin;
    const OutlineModel& model = task->model;
    HarmonicSurface<T> result;
    result.scale = p[0][0] * task->start_m;
    add_resting_shape(result, model);
    for (std::size_t i = 0; i < model.modes.size(); ++i) {
      const auto [n, m] = model.modes[i];
      const T w =
          mode_frequency_rad_s(result.scale, model.density_kg_m3, model.surface_tension_n_m, n);
      const T turn = w * datum->point.time_s;
      const T displacement = p[first_outline_mode + 2 * i][0] * sin(turn) +
                             p[first_outline_mode + 2 * i + 1][0] * cos(turn);
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

// A problem of its own for every set of parameters.
struct Solver {
  const OutlineTask& task;
  OutlineParameters x = {};
  ceres::Problem problem = {};

  Solver(const OutlineTask& of, const OutlineParameters& start, double scale) : task(of), x(start) {
    std::vector<double*> blocks = this->blocks();
    for (const OutlineDatum& datum : task.data) {
      auto* cost = new ceres::DynamicAutoDiffCostFunction<Residual, 6>(
          new Residual{&task, &datum});  // the problem owns it, and the loss
      for (std::size_t k = 0; k < x.size(); ++k) cost->AddParameterBlock(1);
      cost->SetNumResiduals(1);
      problem.AddResidualBlock(cost, new ceres::CauchyLoss(cauchy_width * scale), blocks);
    }
    problem.SetParameterLowerBound(blocks[0], 0, 0.5);
    problem.SetParameterUpperBound(blocks[0], 0, 2);
    for (std::size_t k = first_outline_mode; k < x.size(); ++k) {
      problem.SetParameterLowerBound(blocks[k], 0, -largest_outline_amplitude);
      problem.SetParameterUpperBound(blocks[k], 0, largest_outline_amplitude);
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

OutlineSolution solve(const OutlineTask& task, const OutlineParameters& start, double scale,
                      int iterations) {
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

// The median radius may be 3 % off: the modes do not average out. Over the time of the outlines no
// frequency may then be wrong by more than a radian between neighbouring starts (w ~ r0^-1.5): on a
// long and noisy film the fit otherwise settles beside the right frequency. Films of more than some
// 40 periods get coarser steps.
std::vector<double> radius_starts(const OutlineTask& task) {
  constexpr double uncertainty = 0.03;
  constexpr int most = 12;  // on either side of the middle
  double first = task.data.front().point.time_s, last = first;
  for (const OutlineDatum& datum : task.data) {
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

std::vector<OutlineParameters> all_starts(const OutlineTask& task) {
  constexpr int directions = 4;  // of phi_drop in its period, none at an axis of symmetry
  constexpr double amplitude = 0.03;
  std::vector<OutlineParameters> starts;
  for (const double radius : radius_starts(task)) {
    for (int k = 0; k < (task.period_rad > 0 ? directions : 1); ++k) {
      OutlineParameters x(first_outline_mode + 2 * task.model.modes.size(), amplitude);
      x[0] = radius;
      x[1] = task.period_rad * (k + 0.3) / directions;
      starts.push_back(x);
    }
  }
  return starts;
}

bool same(const OutlineParameters& a, const OutlineParameters& b, double period_rad) {
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
std::vector<OutlineSolution> solve_all(const OutlineTask& task,
                                       const std::vector<OutlineParameters>& starts, double scale,
                                       int iterations, double margin) {
  std::vector<OutlineSolution> found;
  for (const OutlineParameters& start : starts) {
    found.push_back(solve(task, start, scale, iterations));
    make_canonical(task, found.back().x);
  }
  std::stable_sort(
      found.begin(), found.end(),
      [](const OutlineSolution& a, const OutlineSolution& b) { return a.cost < b.cost; });
  std::vector<OutlineSolution> kept;
  for (OutlineSolution& candidate : found) {
    if (candidate.cost > found.front().cost + margin) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const OutlineSolution& other) {
          return same(candidate.x, other.x, task.period_rad);
        })) {
      kept.push_back(std::move(candidate));
    }
  }
  return kept;
}

}  // namespace

OutlineTask make_outline_task(const Outlines& outlines, const OutlineModel& model) {
  refuse_wrong_model(model);
  const std::size_t unknowns = 2 + 2 * model.modes.size();
  if (outlines.points.size() <= unknowns) {
    throw std::runtime_error(fmt::format("{} points; expected more than the {} unknowns",
                                         outlines.points.size(), unknowns));
  }
  OutlineTask task{model};
  HarmonicSurface<double> resting;
  add_resting_shape(resting, model);
  std::vector<double> radii, units;
  for (const OutlinePoint& p : outlines.points) {
    const OutlineRay ray = outline_ray(p.view_elevation_rad, p.view_azimuth_rad, p.theta_rad);
    task.data.push_back({p, ray});
    radii.push_back(p.radius_m / outline_radius_m(resting, ray));
  }
  task.start_m = median(radii);
  for (OutlineDatum& datum : task.data) {
    datum.unit_m = datum.point.sigma_m > 0 ? datum.point.sigma_m : task.start_m;
    units.push_back(datum.unit_m);
  }
  task.floor = rounding * task.start_m / median(units);
  int divisor = 0;
  for (const auto& mode : model.modes) divisor = std::gcd(divisor, mode.m);
  task.period_rad = divisor > 0 ? pi / divisor : 0;
  return task;
}

void make_canonical(const OutlineTask& task, OutlineParameters& x) {
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
    x[first_outline_mode + 2 * i] *= -1;
    x[first_outline_mode + 2 * i + 1] *= -1;
  }
}

// The loss's width follows the median of the residuals, which follows the fit: a few rounds.
OutlineSolutions solve_outlines(const OutlineTask& task) {
  constexpr double alternative = 3.84;  // of cost: 95 % of chi-square with one degree of freedom
  const std::vector<OutlineParameters> starts = all_starts(task);
  const auto scale_of = [&](const std::vector<double>& residuals) {
    return std::max(task.floor, robust_scale(residuals));
  };
  OutlineParameters sphere(starts.front().size(), 0.0);
  sphere[0] = 1;
  OutlineSolutions solutions;
  solutions.starts = static_cast<int>(starts.size());
  solutions.scale = scale_of(Solver(task, sphere, 1).residuals());
  const double loose = 0.5 * static_cast<double>(task.data.size());
  solutions.found = solve_all(task, starts, solutions.scale, 15, loose);
  for (int round = 0; round < 12; ++round) {
    const double scale = scale_of(solutions.found.front().residuals);
    const bool settled = std::abs(scale - solutions.scale) <= 0.01 * scale;
    solutions.scale = scale;
    std::vector<OutlineParameters> again;
    for (const OutlineSolution& candidate : solutions.found) again.push_back(candidate.x);
    solutions.found = solve_all(task, again, scale, 50, settled ? alternative : loose);
    if (settled) break;
  }
  return solutions;
}

FitCovariance outline_covariance(const OutlineTask& task, const OutlineSolution& solution,
                                 double scale) {
  Solver solver(task, solution.x, scale);
  FitCovariance covariance = fit_covariance(solver.problem, solver.blocks());
  if (task.period_rad == 0) covariance.free[1] = true;
  const auto used =
      static_cast<std::size_t>(std::count(covariance.free.begin(), covariance.free.end(), false));
  const double variance = cauchy_variance(solution.residuals, cauchy_width * scale, used);
  covariance.matrix *= std::max(variance, task.floor * task.floor);
  return covariance;
}

}  // namespace pluvia
