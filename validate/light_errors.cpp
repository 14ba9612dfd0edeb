#include "validate/light_errors.h"

#include <cmath>

#include <fmt/format.h>

#include "validate/batch_judge.h"

namespace pluvia {

LightError light_error(const StreakImage& ours, const StreakImage& reference) {
  double difference = 0, size = 0, flux = 0, variance = 0, reference_variance = 0;
  LightError error;
  for (std::size_t i = 0; i < ours.mean.size(); ++i) {
    const double a = ours.mean[i], b = reference.mean[i];
    difference += (a - b) * (a - b);
    size += b * b;
    flux += a;
    error.flux += b;
    variance += ours.variance[i];
    reference_variance += reference.variance[i];
  }
  if (size == 0) return error;
  error.image = std::sqrt(difference / size);
  error.flux_error = flux / error.flux - 1;
  error.estimate = std::sqrt(variance / size);
  error.reference_estimate = std::sqrt(reference_variance / size);
  return error;
}

std::string spread(const std::vector<LightError>& errors, double LightError::*figure) {
  std::vector<double> values;
  for (const LightError& error : errors) values.push_back(100 * std::abs(error.*figure));
  if (values.empty()) return "none";
  return fmt::format("{:.2f} / {:.2f} / {:.2f}", quantile(values, 0.5), quantile(values, 0.9),
                     quantile(values, 1));
}

double total_flux_error(const std::vector<LightError>& errors) {
  double flux = 0, difference = 0;
  for (const LightError& error : errors) {
    flux += error.flux;
    difference += error.flux * error.flux_error;
  }
  return flux > 0 ? difference / flux : 0;
}

}  // namespace pluvia
