#include "validate/fit_json.h"

#include <numbers>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"

namespace pluvia {

namespace {

constexpr double degree = std::numbers::pi / 180;

nlohmann::ordered_json drop_json(const DropShape& drop) {
  nlohmann::ordered_json modes = nlohmann::ordered_json::array();
  for (const Mode& mode : drop.modes) {
    modes.push_back({{"n", mode.n},
                     {"m", mode.m},
                     {"amplitude", mode.amplitude},
                     {"phase_deg", mode.phase_rad / degree}});
  }
  return {{"r0_mm", 1e3 * drop.mean_radius_m},
          {"phi_drop_deg", drop.phi_drop_rad / degree},
          {"modes", modes}};
}

}  // namespace

nlohmann::ordered_json estimates_json(const std::vector<Estimate>& values) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Estimate& estimate : values) {
    nlohmann::ordered_json entry = {{"name", estimate.name},
                                    {"identifiable", is_identifiable(estimate)}};
    if (is_identifiable(estimate)) {
      entry["value"] = estimate.value;
      entry["low"] = estimate.low;
      entry["high"] = estimate.high;
      entry["digits"] = digits(estimate);
    } else {
      entry["why"] = estimate.why;
    }
    list.push_back(entry);
  }
  return list;
}

void write_outline_fit(const std::string& file, const Outlines& outlines, const OutlineFit& fit) {
  nlohmann::ordered_json document = {{"version", 1},
                                     {"source", outlines.source},
                                     {"refusal", fit.refusal},
                                     {"values", estimates_json(fit.values)},
                                     {"alternatives", nlohmann::ordered_json::array()},
                                     {"scatter_mm", fit.scatter_mm},
                                     {"points", fit.points},
                                     {"outliers", fit.outliers},
                                     {"starts", fit.starts},
                                     {"converged", fit.converged}};
  for (const DropShape& drop : fit.alternatives)
    document["alternatives"].push_back(drop_json(drop));
  if (fit.scatter_sigma > 0) document["scatter_sigma"] = fit.scatter_sigma;
  write_file_atomically(file, document_text(document, 2));
}

void write_streak_fit(const std::string& file, const std::string& source, const StreakInput& input,
                      const StreakFit& fit) {
  nlohmann::ordered_json lights = nlohmann::ordered_json::array();
  for (const MeasuredStreak& streak : input.streaks) lights.push_back(light_name(streak.light));
  nlohmann::ordered_json alternatives = nlohmann::ordered_json::array();
  for (const StreakStart& drop : fit.alternatives) {
    alternatives.push_back({{"A20", drop.a20},
                            {"phase20_deg", drop.phase20_rad / degree},
                            {"A31", drop.a31},
                            {"phase31_deg", drop.phase31_rad / degree},
                            {"phi_drop_deg", drop.phi_drop_rad / degree}});
  }
  const nlohmann::ordered_json document = {{"version", 1},
                                           {"source", source},
                                           {"view_elevation_deg", input.view_elevation_deg},
                                           {"lights", lights},
                                           {"refusal", fit.refusal},
                                           {"values", estimates_json(fit.values)},
                                           {"alternatives", alternatives},
                                           {"level", fit.level},
                                           {"residual", fit.residual},
                                           {"traced", fit.traced},
                                           {"converged", fit.converged}};
  write_file_atomically(file, document_text(document, 2));
}

std::string estimate_line(const Estimate& estimate) {
  if (!is_identifiable(estimate)) {
    return fmt::format("{} is not determined: {}", estimate.name, estimate.why);
  }
  return fmt::format("{} {:.6g} ({:.6g} .. {:.6g}), {:.1f} digits", estimate.name, estimate.value,
                     estimate.low, estimate.high, digits(estimate));
}

}  // namespace pluvia
