#include "validate/streak_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "validate/streak_features.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

// Bounds of every component: with all at their bound the drop stays thicker than the generator asks
// for, 1 - sqrt(2) (0.25 / 2 + 0.13 max |P31|) = 0.44 r0, max |P31| = 2.07.
constexpr double largest_20 = 0.25, largest_31 = 0.13;
constexpr double amplitude_step = 0.004;  // of differences: well above the generator's raggedness,
constexpr double angle_step_rad = 0.04;   // and the same displacement at A31 = 0.1
constexpr int generator_seeds = 8;        // from which the generator's noise is estimated
constexpr double most_residual = 0.5;     // of the streaks' own features: no likeness left

// With phases: a20, b20, a31, b31, phi_drop. Without: a20, A31 cos phi_drop, A31 sin phi_drop.
using Parameters = std::vector<double>;

Parameters parameters_of(const StreakStart& start, bool free_phases) {
  if (!free_phases) {
    return {start.a20, start.a31 * std::cos(start.phi_drop_rad),
            start.a31 * std::sin(start.phi_drop_rad)};
  }
  return {start.a20 * std::cos(start.phase20_rad), start.a20 * std::sin(start.phase20_rad),
          start.a31 * std::cos(start.phase31_rad), start.a31 * std::sin(start.phase31_rad),
          start.phi_drop_rad};
}

StreakStart start_of(const Parameters& x) {
  if (x.size() == 3) {
    return {.a20 = x[0], .a31 = std::hypot(x[1], x[2]), .phi_drop_rad = std::atan2(x[2], x[1])};
  }
  // phi_drop + pi is the other sign of the mode of m = 1.
  const double turns = std::floor(x[4] / pi);
  const double sign = std::fmod(std::abs(turns), 2) < 0.5 ? 1 : -1;
  return {std::hypot(x[0], x[1]), std::atan2(x[1], x[0]), std::hypot(x[2], x[3]),
          std::atan2(sign * x[3], sign * x[2]), x[4] - turns * pi};
}

double step_of(std::size_t k) {
  return k == 4 ? angle_step_rad : amplitude_step;
}

// Traces trials and compares them with what was measured.
struct Comparison {
  StreakRequest request = {};
  std::vector<double> measured = {};  // features of all streaks, of root mean square 1
  double scale = 1;                   // what they were divided by
  bool known_level = true;
  int traced = 0;

  std::vector<double> features(const Parameters& x) {
    const StreakStart drop = start_of(x);
    request.drop.modes = {{.n = 2, .m = 0, .amplitude = drop.a20, .phase_rad = drop.phase20_rad},
                          {.n = 3, .m = 1, .amplitude = drop.a31, .phase_rad = drop.phase31_rad}};
    request.drop.phi_drop_rad = drop.phi_drop_rad;
    const TracedStreak streak = trace_streak(request);
    ++traced;
    std::vector<double> all;
    for (const StreakImage& image : streak.light) {
      const auto here = streak_features(request.frame, {image.mean.begin(), image.mean.end()});
      for (const double feature : here) all.push_back(feature / scale);
    }
    return all;
  }
  // Of least squares; the features go with the root of the level.
  double root_level(const std::vector<double>& features) const {
    if (known_level) return 1;
    double both = 0, square = 0;
    for (std::size_t k = 0; k < features.size(); ++k) {
      both += features[k] * measured[k];
      square += features[k] * features[k];
    }
    return square > 0 ? both / square : 0;
  }
  std::vector<double> residuals(const Parameters& x) {
    std::vector<double> r = features(x);
    const double level = root_level(r);
    for (std::size_t k = 0; k < r.size(); ++k) r[k] = level * r[k] - measured[k];
    return r;
  }
};

double sum_of_squares(const std::vector<double>& v) {
  double sum = 0;
  for (const double r : v) sum += r * r;
  return sum;
}

bool within_bounds(const Parameters& x) {
  const std::size_t modes_20 = x.size() == 3 ? 1 : 2;
  for (std::size_t k = 0; k < std::min<std::size_t>(4, x.size()); ++k) {
    if (std::abs(x[k]) > (k < modes_20 ? largest_20 : largest_31)) return false;
  }
  return true;
}

// Residuals by column: d residual / d x_k. Central differences of fixed steps: near an amplitude of
// 0 a relative step would vanish in the generator's raggedness.
Eigen::MatrixXd differences(Comparison& comparison, const Parameters& x) {
  Eigen::MatrixXd jacobian(comparison.measured.size(), x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    Parameters high = x, low = x;
    high[k] += step_of(k);
    low[k] -= step_of(k);
    const std::vector<double> a = comparison.residuals(high), b = comparison.residuals(low);
    for (std::size_t i = 0; i < a.size(); ++i) {
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          (a[i] - b[i]) / (2 * step_of(k));
    }
  }
  return jacobian;
}

// A step out of the bounds fails, and Ceres takes a shorter one: bounds of its own would cost it a
// line search, and that many more traced streaks. The last derivatives are kept: the covariance
// asks for them again.
class StreakCost final : public ceres::CostFunction {
 public:
  StreakCost(Comparison& comparison, std::size_t parameters) : comparison_(comparison) {
    set_num_residuals(static_cast<int>(comparison.measured.size()));
    mutable_parameter_block_sizes()->assign(parameters, 1);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Parameters x(parameter_block_sizes().size());
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = parameters[k][0];
    if (!within_bounds(x)) return false;
    if (x != at_) {
      at_ = x;
      residuals_ = comparison_.residuals(x);
      jacobian_.resize(0, 0);
    }
    std::copy(residuals_.begin(), residuals_.end(), residuals);
    if (jacobians == nullptr) return true;
    if (jacobian_.size() == 0) jacobian_ = differences(comparison_, x);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (jacobians[k] == nullptr) continue;
      Eigen::Map<Eigen::VectorXd>(jacobians[k], jacobian_.rows()) =
          jacobian_.col(static_cast<Eigen::Index>(k));
    }
    return true;
  }
  // At the last parameters asked for.
  const std::vector<double>& residuals() const { return residuals_; }
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

 private:
  Comparison& comparison_;
  mutable Parameters at_ = {};
  mutable std::vector<double> residuals_ = {};
  mutable Eigen::MatrixXd jacobian_ = {};
};

struct Minimum {
  Parameters x = {};
  double square = 0;  // sum of squared residuals
  bool converged = false;
  FitCovariance covariance = {};
  std::vector<double> residuals = {};
  Eigen::MatrixXd jacobian = {};
};

Minimum polish(Comparison& comparison, const Parameters& start, int iterations) {
  Minimum minimum{.x = start};
  std::vector<double*> blocks;
  for (double& value : minimum.x) blocks.push_back(&value);
  auto* const cost = new StreakCost(comparison, start.size());
  ceres::Problem problem;  // owns the cost
  problem.AddResidualBlock(cost, nullptr, blocks);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-3;  // a tenth of what one standard error costs, or less
  options.parameter_tolerance = 1e-3;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  minimum.square = 2 * summary.final_cost;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  minimum.covariance = fit_covariance(problem, blocks);
  minimum.residuals = cost->residuals();
  minimum.jacobian = cost->jacobian();
  return minimum;
}

Comparison make_comparison(const StreakRequest& request, const std::vector<MeasuredStreak>& streaks,
                           bool known_level) {
  Comparison comparison{.request = request, .known_level = known_level};
  comparison.request.lights.clear();
  const auto size = static_cast<std::size_t>(request.frame.width_px) *
                    static_cast<std::size_t>(request.frame.height_px);
  for (const MeasuredStreak& streak : streaks) {
    const std::string name = light_name(streak.light);
    if (streak.values.size() != size) {
      throw std::runtime_error(fmt::format("{}: {} pixels; expected {} x {}", name,
                                           streak.values.size(), request.frame.width_px,
                                           request.frame.height_px));
    }
    double sum = 0;
    for (const double value : streak.values) {
      if (!(value >= 0 && std::isfinite(value))) {
        throw std::runtime_error(
            fmt::format("{}: pixel value {}; expected a finite number >= 0", name, value));
      }
      sum += value;
    }
    if (!(sum > 0)) throw std::runtime_error(name + ": black; expected a streak with light in it");
    comparison.request.lights.push_back(streak.light);
    const auto features = streak_features(request.frame, streak.values);
    comparison.measured.insert(comparison.measured.end(), features.begin(), features.end());
  }
  comparison.scale = std::sqrt(sum_of_squares(comparison.measured) /
                               static_cast<double>(comparison.measured.size()));
  for (double& feature : comparison.measured) feature /= comparison.scale;
  return comparison;
}

ModePair pair_at(const Minimum& minimum, std::size_t at, const std::string& label) {
  const auto k = static_cast<Eigen::Index>(at);
  return {label,
          {minimum.x[at], minimum.x[at + 1]},
          minimum.covariance.matrix.block<2, 2>(k, k),
          minimum.covariance.free[at] || minimum.covariance.free[at + 1]};
}

Estimate scalar_estimate(const std::string& name, const Minimum& minimum, std::size_t at,
                         double value, int freedom, double unit, double widest) {
  if (minimum.covariance.free[at]) return undetermined(name, left_free);
  const auto k = static_cast<Eigen::Index>(at);
  const double half = student_t_95(freedom) * std::sqrt(minimum.covariance.matrix(k, k)) / unit;
  return bounded_estimate(name, value, half, widest, unit == 1 ? "" : " deg");
}

// phi_drop is the direction of the pair (A31 cos, A31 sin): its "phase".
std::vector<Estimate> estimates_without_phases(const Minimum& minimum, int freedom) {
  std::vector<Estimate> values = {
      scalar_estimate("A20", minimum, 0, minimum.x[0], freedom, 1, largest_20)};
  add_mode_estimates(pair_at(minimum, 1, "31"), freedom, largest_31, values);
  values.back().name = "phi_drop_deg";
  return values;
}

std::vector<Estimate> estimates_with_phases(const Minimum& minimum, int freedom) {
  std::vector<Estimate> values;
  add_mode_estimates(pair_at(minimum, 0, "20"), freedom, largest_20, values);
  const bool differs = add_mode_estimates(pair_at(minimum, 2, "31"), freedom, largest_31, values);
  const std::string name = "phi_drop_deg";
  values.push_back(
      differs ? scalar_estimate(name, minimum, 4, minimum.x[4] / degree, freedom, degree, 45)
              : undetermined(name, "the amplitude A31 cannot be told from zero"));
  return values;
}

// The starts in the order of how well they fit.
std::vector<Parameters> best_starts(Comparison& comparison, const std::vector<StreakStart>& starts,
                                    const StreakFitOptions& options,
                                    const std::function<void(double)>& progress) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const Parameters x = parameters_of(starts[k], options.free_phases);
    order.emplace_back(sum_of_squares(comparison.residuals(x)), k);
    if (progress) progress(0.5 * static_cast<double>(k + 1) / static_cast<double>(starts.size()));
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(options.polished, order.size()));
  std::vector<Parameters> best;
  for (const auto& [square, k] : order)
    best.push_back(parameters_of(starts[k], options.free_phases));
  return best;
}

// In units of the displacement that a difference makes.
double distance(const StreakStart& a, const StreakStart& b) {
  const auto point = [](const StreakStart& s) {
    return Eigen::Vector4d(s.a20 * std::cos(s.phase20_rad), s.a20 * std::sin(s.phase20_rad),
                           s.a31 * std::cos(s.phase31_rad), s.a31 * std::sin(s.phase31_rad));
  };
  return (point(a) - point(b)).norm() +
         std::min(a.a31, b.a31) * std::abs(std::remainder(a.phi_drop_rad - b.phi_drop_rad, 2 * pi));
}

// What the generator's own noise does to the parameters: the best drop traced with other seeds
// moves the minimum by -C J^T (difference of the features). The residuals hold that noise too, but
// not as white noise: neighbouring rows share the instants that were traced.
Eigen::MatrixXd generator_covariance(Comparison& comparison, const Minimum& best) {
  const Eigen::MatrixXd& jacobian = best.jacobian;
  const std::uint64_t seed = comparison.request.seed;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  for (int k = 1; k <= generator_seeds; ++k) {
    comparison.request.seed = seed + static_cast<std::uint64_t>(k) * 7919u;
    const std::vector<double> there = comparison.residuals(best.x);
    Eigen::VectorXd change(jacobian.rows());
    for (std::size_t i = 0; i < there.size(); ++i) {
      change[static_cast<Eigen::Index>(i)] = there[i] - best.residuals[i];
    }
    const Eigen::VectorXd shift = best.covariance.matrix * (jacobian.transpose() * change);
    // Of two traced streaks, the trial's and the other seed's: as between the trial and a measured
    // streak as noisy as it.
    sum += shift * shift.transpose() / generator_seeds;
  }
  comparison.request.seed = seed;
  return sum;
}

StreakFit describe(Comparison& comparison, std::vector<Minimum>& minima,
                   const StreakFitOptions& options) {
  std::stable_sort(minima.begin(), minima.end(),
                   [](const Minimum& a, const Minimum& b) { return a.square < b.square; });
  Minimum& best = minima.front();
  StreakStart drop = start_of(best.x);
  const double n = static_cast<double>(comparison.measured.size());
  const double independent = n / feature_correlation;
  // Two variances are added; the one that rests on fewer numbers decides.
  const int freedom = std::clamp(static_cast<int>(independent) - static_cast<int>(best.x.size()), 1,
                                 generator_seeds);
  // Of one residual, and what its neighbours' likeness adds to the covariance.
  // A streak compared with its own trial leaves nothing: rounding is the least.
  const double variance = std::max(1e-12, best.square / (n - static_cast<double>(best.x.size())));
  const Eigen::MatrixXd generator = generator_covariance(comparison, best);
  best.covariance.matrix = variance * feature_correlation * best.covariance.matrix + generator;
  best.x = parameters_of(drop, options.free_phases);
  StreakFit fit;
  fit.values = options.free_phases ? estimates_with_phases(best, freedom)
                                   : estimates_without_phases(best, freedom);
  fit.converged = best.converged;
  fit.residual = std::sqrt(best.square / n);
  const double root = comparison.root_level(comparison.features(best.x));
  fit.level = root * root;
  fit.traced = comparison.traced;
  if (fit.residual > most_residual) {
    fit.refusal = fmt::format(
        "the best drop leaves {:.0f} % of the streak's brightness pattern; expected at most {:.0f} "
        "%",
        100 * fit.residual, 100 * most_residual);
    for (Estimate& value : fit.values) value = undetermined(value.name, fit.refusal);
    return fit;
  }
  for (const Minimum& other : minima) {
    // 3.84: 95 % of chi-square with one degree of freedom.
    const bool as_good = other.square - best.square < 3.84 * variance * feature_correlation;
    if (as_good && distance(start_of(other.x), drop) > 0.02) {
      fit.alternatives.push_back(start_of(other.x));
    }
  }
  return fit;
}

}  // namespace

std::vector<StreakStart> streak_starts(bool free_phases) {
  std::vector<StreakStart> starts;
  if (!free_phases) {
    for (const double a20 : {0.06, 0.12, 0.18}) {
      starts.push_back({.a20 = a20});
      for (const double a31 : {0.05, 0.1}) {
        for (int k = 0; k < 8; ++k) {
          starts.push_back({.a20 = a20, .a31 = a31, .phi_drop_rad = k * pi / 4});
        }
      }
    }
    return starts;
  }
  for (const double a20 : {0.08, 0.16}) {
    for (int p20 = 0; p20 < 4; ++p20) {
      for (int p31 = 0; p31 < 4; ++p31) {
        for (int k = 0; k < 4; ++k) {
          starts.push_back({a20, p20 * pi / 2, 0.08, p31 * pi / 2, (k + 0.5) * pi / 4});
        }
      }
    }
  }
  return starts;
}

StreakFit fit_streak(const StreakRequest& request, const std::vector<MeasuredStreak>& streaks,
                     const std::vector<StreakStart>& starts, const StreakFitOptions& options,
                     const std::function<void(double)>& progress) {
  if (streaks.empty() || starts.empty() || options.polished == 0) {
    throw std::invalid_argument("no streak or no start; expected some of each");
  }
  Comparison comparison = make_comparison(request, streaks, options.known_level);
  std::vector<Minimum> minima;
  const auto chosen = best_starts(comparison, starts, options, progress);
  for (const Parameters& start : chosen) {
    minima.push_back(polish(comparison, start, options.iterations));
    if (progress)
      progress(0.5 + 0.5 * static_cast<double>(minima.size()) / static_cast<double>(chosen.size()));
  }
  return describe(comparison, minima, options);
}

}  // namespace pluvia
