#include "validate/amplitude_fit.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "oscillation/mode_estimates.h"
#include "validate/amplitude_table.h"

namespace pluvia {

namespace {

constexpr int judged_elevation_deg = 50;
constexpr double loss_width = 0.15;  // of log10: the size of the residuals of a good set

// Of one set: its factors, and what is fitted.
struct SetTask {
  const OscillationSet* set = nullptr;
  std::vector<RealFactor> fitted = {}, judged = {};
  double a20 = 0, a31 = 0;
};

std::vector<SetTask> make_tasks(const std::vector<OscillationSet>& sets,
                                const std::vector<RealFactor>& factors) {
  std::vector<SetTask> tasks;
  std::size_t fitted = 0;
  for (const OscillationSet& set : sets) {
    SetTask task{.set = &set};
    for (const RealFactor& factor : factors) {
      if (factor.oscillation != set.index) continue;
      (factor.light.elevation_deg == judged_elevation_deg ? task.judged : task.fitted)
          .push_back(factor);
    }
    if (task.fitted.empty()) continue;
    fitted += task.fitted.size();
    tasks.push_back(std::move(task));
  }
  // With one light fewer, for the jackknife, they must still be enough.
  if (fitted <= 3 * tasks.size() + 1) {
    throw std::runtime_error(
        fmt::format("{} factors of light elevations 10 and 90 for {} sets; "
                    "expected more than three a set and one",
                    fitted, tasks.size()));
  }
  return tasks;
}

// Of any set: the number of lights that an amplitude rests on.
std::size_t most_factors(const std::vector<SetTask>& tasks) {
  std::size_t most = 0;
  for (const SetTask& task : tasks) most = std::max(most, task.fitted.size());
  return most;
}

// The node of the grid with the smallest sum of |residuals| (robust) in that unit.
void start_from_best_node(const CountedModel& tracer, const AmplitudeTables& tables, double unit,
                          SetTask& task) {
  const AmplitudeTable& table = tables.of.at(task.set->phi_drop_deg);
  const std::size_t columns = tables.grid.a31.size();
  double least = -1;
  for (std::size_t node = 0; node < tables.nodes(); ++node) {
    double sum = 0;
    for (const RealFactor& factor : task.fitted) {
      const double ours = table.values[tracer.light_index(factor.light)][node];
      sum += std::abs(ours - std::log10(factor.factor) - unit);
    }
    if (least >= 0 && sum >= least) continue;
    least = sum;
    task.a20 = tables.grid.a20[node / columns];
    task.a31 = tables.grid.a31[node % columns];
  }
}

// Median of ours / theirs over all sets, each at the amplitudes of the preset nearest to a node:
// where the search for starts begins.
double first_unit(const CountedModel& tracer, const AmplitudeTables& tables,
                  const std::vector<SetTask>& tasks) {
  std::vector<double> ratios;
  const auto nearest = [](const std::vector<double>& grid, double value) {
    const auto at = std::min_element(grid.begin(), grid.end(), [&](double a, double b) {
      return std::abs(a - value) < std::abs(b - value);
    });
    return static_cast<std::size_t>(at - grid.begin());
  };
  for (const SetTask& task : tasks) {
    const std::size_t node = nearest(tables.grid.a20, task.set->a20) * tables.grid.a31.size() +
                             nearest(tables.grid.a31, task.set->a31);
    const AmplitudeTable& table = tables.of.at(task.set->phi_drop_deg);
    for (const RealFactor& factor : task.fitted) {
      ratios.push_back(table.values[tracer.light_index(factor.light)][node] -
                       std::log10(factor.factor));
    }
  }
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

struct Joint {
  ceres::Problem problem = {};
  std::vector<double*> parameters = {};  // the unit, then a20 and a31 of every set
  std::size_t residuals = 0;
};

void build_joint(Joint& joint, const CountedModel& tracer, const AmplitudeTables& tables,
                 double& unit, std::vector<SetTask>& tasks) {
  joint.parameters = {&unit};
  for (SetTask& task : tasks) {
    const AmplitudeTable& table = tables.of.at(task.set->phi_drop_deg);
    for (const RealFactor& factor : task.fitted) {
      const auto& values = table.values[tracer.light_index(factor.light)];
      auto* cost = new ceres::AutoDiffCostFunction<TableResidual, 1, 1, 1, 1>(
          new TableResidual(tables, values, factor.factor));  // owned by the problem, as the loss
      joint.problem.AddResidualBlock(cost, new ceres::SoftLOneLoss(loss_width), &unit, &task.a20,
                                     &task.a31);
      ++joint.residuals;
    }
    joint.parameters.insert(joint.parameters.end(), {&task.a20, &task.a31});
    joint.problem.SetParameterLowerBound(&task.a20, 0, 0);
    joint.problem.SetParameterUpperBound(&task.a20, 0, tables.grid.a20.back());
    joint.problem.SetParameterLowerBound(&task.a31, 0, 0);
    joint.problem.SetParameterUpperBound(&task.a31, 0, tables.grid.a31.back());
  }
}

struct Solved {
  FitCovariance covariance = {};
  std::vector<double> x = {};  // in the order of Joint::parameters
  int freedom = 1;
  bool converged = false;
};

Solved solve_joint(const CountedModel& tracer, const AmplitudeTables& tables, double& unit,
                   std::vector<SetTask>& tasks) {
  Joint joint;
  build_joint(joint, tracer, tables, unit, tasks);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &joint.problem, &summary);
  ceres::Problem::EvaluateOptions plain;
  plain.apply_loss_function = false;
  double half_square = 0;
  joint.problem.Evaluate(plain, &half_square, nullptr, nullptr, nullptr);
  Solved solved;
  solved.covariance = fit_covariance(joint.problem, joint.parameters);
  solved.freedom = static_cast<int>(joint.residuals - joint.parameters.size());
  // What is left over is mostly the model's, not noise: it makes the intervals as wide as it says.
  solved.covariance.matrix *= 2 * half_square / solved.freedom;
  solved.converged = summary.termination_type == ceres::CONVERGENCE;
  for (const double* parameter : joint.parameters) solved.x.push_back(*parameter);
  return solved;
}

// Variances of the parameters by the jackknife over the lights: the fit is repeated without each of
// them, from where it stands. It sees what the covariance cannot: residuals that go together, and a
// table that bends between the solutions.
std::vector<double> jackknife_variances(const CountedModel& tracer, const AmplitudeTables& tables,
                                        double unit, const std::vector<SetTask>& tasks,
                                        const Solved& solved) {
  std::set<std::size_t> lights;
  for (const SetTask& task : tasks) {
    for (const RealFactor& factor : task.fitted) lights.insert(tracer.light_index(factor.light));
  }
  std::vector<double> sum(solved.x.size(), 0.0), square = sum;
  for (const std::size_t left_out : lights) {
    std::vector<SetTask> rest = tasks;
    double rest_unit = unit;
    for (SetTask& task : rest) {
      std::erase_if(task.fitted, [&](const RealFactor& factor) {
        return tracer.light_index(factor.light) == left_out;
      });
    }
    const Solved again = solve_joint(tracer, tables, rest_unit, rest);
    for (std::size_t k = 0; k < sum.size(); ++k) {
      const double shift = again.x[k] - solved.x[k];
      sum[k] += shift;
      square[k] += shift * shift;
    }
  }
  const double n = static_cast<double>(lights.size());
  for (std::size_t k = 0; k < sum.size(); ++k) {
    square[k] = (n - 1) / n * std::max(0.0, square[k] - sum[k] * sum[k] / n);
  }
  return square;
}

// The covariance's variances, or the jackknife's where they are larger; as certain as the number of
// lights lets them be.
void widen(Solved& solved, const std::vector<double>& variances, std::size_t lights) {
  for (std::size_t k = 0; k < variances.size(); ++k) {
    double& here =
        solved.covariance.matrix(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k));
    here = std::max(here, variances[k]);
  }
  solved.freedom = std::clamp(static_cast<int>(lights) - 1, 1, solved.freedom);
}

Estimate amplitude_estimate(const std::string& name, double value, double highest,
                            const Solved& solved, std::size_t index) {
  if (solved.covariance.free[index]) return undetermined(name, left_free);
  if (value > highest - 1e-6) {
    return undetermined(name, fmt::format("it would lie beyond {}, where the table ends", highest));
  }
  const auto k = static_cast<Eigen::Index>(index);
  const double half = student_t_95(solved.freedom) * std::sqrt(solved.covariance.matrix(k, k));
  Estimate estimate = bounded_estimate(name, value, half, highest, "");
  estimate.low = std::max(0.0, estimate.low);
  return estimate;
}

double rms(const std::vector<double>& values) {
  if (values.empty()) return -1;
  double square = 0;
  for (const double v : values) square += v * v;
  return std::sqrt(square / static_cast<double>(values.size()));
}

// log10(ours / theirs) of those factors.
std::vector<double> ratios(const CountedModel& tracer, const LogMaxima& ours,
                           const std::vector<RealFactor>& factors, double unit) {
  std::vector<double> values;
  for (const RealFactor& factor : factors) {
    values.push_back(ours[tracer.light_index(factor.light)] - std::log10(factor.factor) - unit);
  }
  return values;
}

// The sets as fitted and as the preset has them, traced with a seed that no table has seen.
void judge(CountedModel& tracer, const std::vector<SetTask>& tasks, AmplitudeFit& fit) {
  constexpr std::uint64_t fresh_seed = 9001;
  std::vector<LogMaxima> before;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const SetTask& task = tasks[i];
    const LogMaxima ours = tracer(task.a20, task.a31, task.set->phi_drop_deg, fresh_seed);
    fit.sets[i].rms_fitted = rms(ratios(tracer, ours, task.fitted, fit.log10_constant));
    fit.sets[i].rms_judged = rms(ratios(tracer, ours, task.judged, fit.log10_constant));
    before.push_back(tracer(task.set->a20, task.set->a31, task.set->phi_drop_deg, fresh_seed));
    for (const double r : ratios(tracer, before.back(), task.fitted, 0)) {
      sum += r;
      ++count;
    }
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    fit.sets[i].rms_judged_preset =
        rms(ratios(tracer, before[i], tasks[i].judged, sum / static_cast<double>(count)));
  }
}

}  // namespace

AmplitudeFit fit_amplitudes(const std::vector<OscillationSet>& sets,
                            const std::vector<RealFactor>& factors, const AmplitudeModel& model,
                            const AmplitudeGrid& grid,
                            const std::function<void(double)>& progress) {
  std::vector<SetTask> tasks = make_tasks(sets, factors);
  CountedModel tracer{model};
  std::set<double> directions;
  for (const SetTask& task : tasks) directions.insert(task.set->phi_drop_deg);
  const AmplitudeTables tables = make_amplitude_tables(tracer, directions, grid, progress);
  AmplitudeFit fit;
  fit.log10_constant = first_unit(tracer, tables, tasks);
  for (SetTask& task : tasks) start_from_best_node(tracer, tables, fit.log10_constant, task);
  Solved solved = solve_joint(tracer, tables, fit.log10_constant, tasks);
  widen(solved, jackknife_variances(tracer, tables, fit.log10_constant, tasks, solved),
        most_factors(tasks));
  fit.converged = solved.converged;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const SetTask& task = tasks[i];
    fit.sets.push_back({.oscillation = task.set->index, .phi_drop_deg = task.set->phi_drop_deg});
    fit.sets.back().values = {
        amplitude_estimate("A20", task.a20, grid.a20.back(), solved, 1 + 2 * i),
        amplitude_estimate("A31", task.a31, grid.a31.back(), solved, 2 + 2 * i)};
  }
  judge(tracer, tasks, fit);
  if (tables.entries > 0) {
    fit.log10_noise = std::sqrt(tables.noise_square / static_cast<double>(tables.entries));
  }
  fit.traced = tracer.traced;
  return fit;
}

}  // namespace pluvia
