#include "validate/factor_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include <ceres/ceres.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"
#include "validate/fit_json.h"

namespace pluvia {

namespace {

constexpr int fitted_elevations_deg[] = {10, 90};
constexpr double difference_step = 0.02;  // relative

bool is_fitted(const RealFactor& factor) {
  return factor.oscillation == 0 &&
         std::any_of(std::begin(fitted_elevations_deg), std::end(fitted_elevations_deg),
                     [&](int v) { return factor.light.elevation_deg == v; });
}

// log10 of the brightest pixel of one set's streaks, over the real factor's, for the fitted
// factors.
std::vector<double> log_ratios(const Preset& preset, const std::vector<RealFactor>& factors) {
  StreakRequest request = shard_request(preset, {.oscillation = 0});
  request.environment.transfer_degree = -1;  // lights alone are fitted
  request.lights.clear();
  std::vector<double> theirs;
  for (const RealFactor& factor : factors) {
    if (!is_fitted(factor)) continue;
    request.lights.push_back(factor.light);
    theirs.push_back(factor.factor);
  }
  const TracedStreak streak = trace_streak(request);
  std::vector<double> ratios;
  for (std::size_t k = 0; k < theirs.size(); ++k) {
    const auto& mean = streak.light[k].mean;
    ratios.push_back(std::log10(*std::max_element(mean.begin(), mean.end()) / theirs[k]));
  }
  return ratios;
}

// A Ceres cost over any number of parameters, from a plain function.
struct Residuals {
  std::function<std::vector<double>(const double*)> of;
  bool operator()(double const* const* parameters, double* residuals) const {
    const std::vector<double> values = of(parameters[0]);
    std::copy(values.begin(), values.end(), residuals);
    return true;
  }
};

struct Solution {
  std::vector<double> x = {}, standard_error = {};
  double square_before = 0, square_after = 0;
  std::size_t residuals = 0;
  bool converged = false;
};

double sum_of_squares(const std::vector<double>& v) {
  double sum = 0;
  for (const double r : v) sum += r * r;
  return sum;
}

// Square roots of the covariance's diagonal, scaled by the residuals; negative where it is
// singular.
std::vector<double> standard_errors(ceres::Problem& problem, std::vector<double>& x, double square,
                                    std::size_t residuals) {
  const std::size_t n = x.size();
  ceres::Covariance covariance({});
  std::vector<double> matrix(n * n, -1.0), errors;
  const std::vector<std::pair<const double*, const double*>> blocks = {{x.data(), x.data()}};
  if (!covariance.Compute(blocks, &problem) ||
      !covariance.GetCovarianceBlock(x.data(), x.data(), matrix.data())) {
    return std::vector<double>(n, -1.0);
  }
  const double scale = square / static_cast<double>(residuals - n);
  for (std::size_t i = 0; i < n; ++i) errors.push_back(std::sqrt(scale * matrix[i * n + i]));
  return errors;
}

Solution solve(const std::vector<double>& start, const std::vector<double>& low,
               const std::vector<double>& high, const Residuals& residuals) {
  Solution solution;
  solution.x = start;
  const std::vector<double> first = residuals.of(start.data());
  solution.square_before = sum_of_squares(first);
  solution.residuals = first.size();
  ceres::NumericDiffOptions differences;
  differences.relative_step_size = difference_step;
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Residuals, ceres::FORWARD>(
      new Residuals(residuals), ceres::TAKE_OWNERSHIP, differences);
  cost->AddParameterBlock(static_cast<int>(start.size()));
  cost->SetNumResiduals(static_cast<int>(first.size()));
  ceres::Problem problem;  // owns the cost and the loss
  problem.AddResidualBlock(cost, new ceres::SoftLOneLoss(0.2), solution.x.data());
  for (std::size_t i = 0; i < start.size(); ++i) {
    problem.SetParameterLowerBound(solution.x.data(), static_cast<int>(i), low[i]);
    problem.SetParameterUpperBound(solution.x.data(), static_cast<int>(i), high[i]);
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 6;
  options.function_tolerance = 1e-3;  // a hundredth of the residuals' spread
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.square_after = sum_of_squares(residuals.of(solution.x.data()));
  solution.standard_error =
      standard_errors(problem, solution.x, solution.square_after, first.size());
  return solution;
}

// An interval as wide as the value itself says nothing.
bool is_determined(const Solution& solution, std::size_t index) {
  const double error = solution.standard_error[index];
  return error >= 0 && error <= std::abs(solution.x[index]);
}

// The value where the factors determine it, else the start; the solution then keeps the start too.
FittedValue fitted(const std::string& name, double start, Solution& solution, std::size_t index) {
  const bool determined = is_determined(solution, index);
  if (!determined) solution.x[index] = start;
  return {name, start, solution.x[index], solution.standard_error[index], determined};
}

}  // namespace

FactorFit fit_factors(const Preset& preset, const std::vector<RealFactor>& factors) {
  if (std::none_of(factors.begin(), factors.end(), is_fitted)) {
    throw std::runtime_error(
        "no factor of set 0 and light elevation 10 or 90; expected some to fit");
  }
  const Residuals residuals{[&](const double* x) {
    Preset trial = preset;
    trial.cone_half_angle_deg = x[0];
    std::vector<double> r = log_ratios(trial, factors);
    for (double& v : r) v -= x[1];
    return r;
  }};
  double mean = 0;
  const std::vector<double> ratios = log_ratios(preset, factors);
  for (const double r : ratios) mean += r / static_cast<double>(ratios.size());
  Solution solution =
      solve({preset.cone_half_angle_deg, mean}, {1, mean - 2}, {12, mean + 2}, residuals);
  FactorFit fit;
  fit.cone = fitted("cone_half_angle_deg", preset.cone_half_angle_deg, solution, 0);
  if (!fit.cone.identifiable) solution.x[1] = mean;  // the unit that goes with the start
  fit.log10_constant = solution.x[1];
  fit.converged = solution.converged;
  const double count = static_cast<double>(ratios.size());
  fit.rms_before = std::sqrt(solution.square_before / count);
  // What is not determined keeps its start, and the start's residuals.
  const double kept = fit.cone.identifiable ? solution.square_after : solution.square_before;
  fit.rms_after = std::sqrt(kept / count);
  return fit;
}

void write_factor_fit(const std::string& file, const FactorFit& fit,
                      const AmplitudeFit& amplitudes) {
  nlohmann::ordered_json cone = {{"name", fit.cone.name}, {"start", fit.cone.start}};
  if (fit.cone.identifiable) {
    cone["value"] = fit.cone.value;
    cone["standard_error"] = fit.cone.standard_error;
  }
  cone["identifiable"] = fit.cone.identifiable;
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  for (const SetAmplitudes& set : amplitudes.sets) {
    sets.push_back({{"oscillation", set.oscillation},
                    {"phi_drop_deg", set.phi_drop_deg},
                    {"values", estimates_json(set.values)},
                    {"rms_fitted", set.rms_fitted},
                    {"rms_judged", set.rms_judged},
                    {"rms_judged_preset", set.rms_judged_preset}});
  }
  const nlohmann::ordered_json document = {{"version", 1},
                                           {"values", {cone}},
                                           {"log10_constant", fit.log10_constant},
                                           {"rms_before", fit.rms_before},
                                           {"rms_after", fit.rms_after},
                                           {"converged", fit.converged},
                                           {"amplitudes",
                                            {{"sets", sets},
                                             {"log10_constant", amplitudes.log10_constant},
                                             {"log10_noise", amplitudes.log10_noise},
                                             {"traced", amplitudes.traced},
                                             {"converged", amplitudes.converged}}}};
  write_file_atomically(file, document_text(document, 2));
}

}  // namespace pluvia
