#include "validate/amplitude_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <stdexcept>

#include <ceres/ceres.h>
#include <ceres/cubic_interpolation.h>
#include <fmt/format.h>

#include "oscillation/mode_estimates.h"

namespace pluvia {

namespace {

constexpr int judged_elevation_deg = 50;
constexpr double loss_width = 0.15;  // of log10: the size of the residuals of a good set

// log10 of the brightest pixel of every light.
using LogMaxima = std::vector<double>;

struct Tracer {
  const AmplitudeModel& model;
  int traced = 0;

  LogMaxima operator()(double a20, double a31, double phi_drop_deg, std::uint64_t seed) {
    ++traced;
    return model.log_maxima(a20, a31, phi_drop_deg, seed);
  }
  std::size_t light_index(const LightDirection& light) const {
    const auto at = std::find(model.lights.begin(), model.lights.end(), light);
    assert(at != model.lights.end());
    return static_cast<std::size_t>(at - model.lights.begin());
  }
};

// For one phi_drop: values[light][a20 index * a31 count + a31 index].
struct Table {
  std::vector<std::vector<double>> values = {};
};

struct Tables {
  AmplitudeGrid grid = {};
  std::map<double, Table> of = {};  // by phi_drop_deg
  double noise_square = 0;          // summed over entries
  std::size_t entries = 0;

  std::size_t nodes() const { return grid.a20.size() * grid.a31.size(); }
  double step_20() const { return grid.a20[1] - grid.a20[0]; }
  double step_31() const { return grid.a31[1] - grid.a31[0]; }
};

// The mean over the seeds; their spread goes into the tables' noise.
LogMaxima node_value(Tracer& tracer, Tables& tables, double a20, double a31, double phi_drop_deg) {
  std::vector<LogMaxima> samples;
  for (int k = 0; k < tables.grid.seeds; ++k) {
    samples.push_back(tracer(a20, a31, phi_drop_deg, 100 + static_cast<std::uint64_t>(k)));
  }
  LogMaxima mean(samples.front().size(), 0.0);
  for (std::size_t light = 0; light < mean.size(); ++light) {
    for (const LogMaxima& sample : samples) mean[light] += sample[light] / tables.grid.seeds;
    double square = 0;
    for (const LogMaxima& sample : samples) square += std::pow(sample[light] - mean[light], 2);
    if (samples.size() > 1) {
      // Of the mean of the seeds.
      tables.noise_square += square / static_cast<double>(samples.size() * (samples.size() - 1));
      ++tables.entries;
    }
  }
  return mean;
}

// A31 = 0 has no direction: its column is traced once for all.
Tables make_tables(Tracer& tracer, const std::set<double>& directions, const AmplitudeGrid& grid,
                   const std::function<void(double)>& progress) {
  Tables tables{.grid = grid};
  const std::size_t columns = grid.a31.size(), lights = tracer.model.lights.size();
  for (const double phi : directions) {
    tables.of[phi].values.assign(lights, std::vector<double>(tables.nodes()));
  }
  const double total =
      static_cast<double>(grid.a20.size() * ((columns - 1) * directions.size() + 1));
  int done = 0;
  const auto put = [&](double phi, std::size_t node, const LogMaxima& maxima) {
    for (std::size_t k = 0; k < lights; ++k) tables.of[phi].values[k][node] = maxima[k];
  };
  for (std::size_t i = 0; i < grid.a20.size(); ++i) {
    const LogMaxima level = node_value(tracer, tables, grid.a20[i], 0, 0);
    if (progress) progress(++done / total);
    for (const double phi : directions) {
      put(phi, i * columns, level);
      for (std::size_t j = 1; j < columns; ++j) {
        put(phi, i * columns + j, node_value(tracer, tables, grid.a20[i], grid.a31[j], phi));
        if (progress) progress(++done / total);
      }
    }
  }
  return tables;
}

using Grid = ceres::Grid2D<double, 1>;

// The table with a border of linear continuation: Ceres repeats the last value there, which would
// bend the surface in its outermost cells.
std::vector<double> with_border(const std::vector<double>& values, std::size_t rows,
                                std::size_t columns) {
  const auto along = [](std::size_t k, std::size_t count, auto at) {
    if (k == 0) return 2 * at(0) - at(1);
    if (k == count + 1) return 2 * at(count - 1) - at(count - 2);
    return at(k - 1);
  };
  std::vector<double> wider;
  for (std::size_t i = 0; i < rows + 2; ++i) {
    for (std::size_t j = 0; j < columns + 2; ++j) {
      wider.push_back(along(i, rows, [&](std::size_t row) {
        return along(j, columns, [&](std::size_t c) { return values[row * columns + c]; });
      }));
    }
  }
  return wider;
}

// log10(ours / theirs) of one factor, minus the unit.
struct TableResidual {
  std::vector<double> table;
  Grid grid;
  ceres::BiCubicInterpolator<Grid> surface;
  double step_20 = 0, step_31 = 0, log_theirs = 0;

  TableResidual(const Tables& tables, const std::vector<double>& values, double theirs)
      : table(with_border(values, tables.grid.a20.size(), tables.grid.a31.size())),
        grid(table.data(), -1, static_cast<int>(tables.grid.a20.size()) + 1, -1,
             static_cast<int>(tables.grid.a31.size()) + 1),
        surface(grid),
        step_20(tables.step_20()),
        step_31(tables.step_31()),
        log_theirs(std::log10(theirs)) {}
  TableResidual(const TableResidual&) = delete;  // the surface refers to the grid beside it
  TableResidual& operator=(const TableResidual&) = delete;

  template <typename T>
  bool operator()(const T* unit, const T* a20, const T* a31, T* residual) const {
    T ours;
    surface.Evaluate(a20[0] / step_20, a31[0] / step_31, &ours);
    residual[0] = ours - log_theirs - unit[0];
    return true;
  }
};

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
void start_from_best_node(const Tracer& tracer, const Tables& tables, double unit, SetTask& task) {
  const Table& table = tables.of.at(task.set->phi_drop_deg);
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
double first_unit(const Tracer& tracer, const Tables& tables, const std::vector<SetTask>& tasks) {
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
    const Table& table = tables.of.at(task.set->phi_drop_deg);
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

void build_joint(Joint& joint, const Tracer& tracer, const Tables& tables, double& unit,
                 std::vector<SetTask>& tasks) {
  joint.parameters = {&unit};
  for (SetTask& task : tasks) {
    const Table& table = tables.of.at(task.set->phi_drop_deg);
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

Solved solve_joint(const Tracer& tracer, const Tables& tables, double& unit,
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
std::vector<double> jackknife_variances(const Tracer& tracer, const Tables& tables, double unit,
                                        const std::vector<SetTask>& tasks, const Solved& solved) {
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
std::vector<double> ratios(const Tracer& tracer, const LogMaxima& ours,
                           const std::vector<RealFactor>& factors, double unit) {
  std::vector<double> values;
  for (const RealFactor& factor : factors) {
    values.push_back(ours[tracer.light_index(factor.light)] - std::log10(factor.factor) - unit);
  }
  return values;
}

// The sets as fitted and as the preset has them, traced with a seed that no table has seen.
void judge(Tracer& tracer, const std::vector<SetTask>& tasks, AmplitudeFit& fit) {
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

AmplitudeModel traced_model(const Preset& preset, const std::vector<RealFactor>& factors) {
  StreakRequest request = shard_request(preset, {.oscillation = preset.sets.front().index});
  request.lights.clear();
  for (const RealFactor& factor : factors) {
    const auto& lights = request.lights;
    if (std::find(lights.begin(), lights.end(), factor.light) != lights.end()) continue;
    request.lights.push_back(factor.light);
  }
  const auto log_maxima = [request](double a20, double a31, double phi_drop_deg,
                                    std::uint64_t seed) {
    StreakRequest trial = request;
    trial.drop.modes.clear();
    if (a20 != 0) trial.drop.modes.push_back({.n = 2, .m = 0, .amplitude = a20});
    if (a31 != 0) trial.drop.modes.push_back({.n = 3, .m = 1, .amplitude = a31});
    trial.drop.phi_drop_rad = phi_drop_deg * std::numbers::pi / 180;
    trial.seed = seed;
    const TracedStreak streak = trace_streak(trial);
    LogMaxima maxima;
    for (std::size_t k = 0; k < streak.light.size(); ++k) {
      const auto& mean = streak.light[k].mean;
      const double brightest = *std::max_element(mean.begin(), mean.end());
      if (!(brightest > 0)) {
        throw std::runtime_error(fmt::format("{} of A20 = {}, A31 = {} is black; expected light",
                                             light_name(trial.lights[k]), a20, a31));
      }
      maxima.push_back(std::log10(brightest));
    }
    return maxima;
  };
  return {request.lights, log_maxima};
}

AmplitudeFit fit_amplitudes(const std::vector<OscillationSet>& sets,
                            const std::vector<RealFactor>& factors, const AmplitudeModel& model,
                            const AmplitudeGrid& grid,
                            const std::function<void(double)>& progress) {
  std::vector<SetTask> tasks = make_tasks(sets, factors);
  Tracer tracer{model};
  std::set<double> directions;
  for (const SetTask& task : tasks) directions.insert(task.set->phi_drop_deg);
  const Tables tables = make_tables(tracer, directions, grid, progress);
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
