#include "validate/fit_json.h"

#include <numbers>

#include <fmt/format.h>

#include "atlas/atomic_file.h"

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
  write_file_atomically(file, document.dump(2) + "\n");
}

std::string estimate_line(const Estimate& estimate) {
  if (!is_identifiable(estimate)) {
    return fmt::format("{} is not determined: {}", estimate.name, estimate.why);
  }
  return fmt::format("{} {:.6g} ({:.6g} .. {:.6g}), {:.1f} digits", estimate.name, estimate.value,
                     estimate.low, estimate.high, digits(estimate));
}

}  // namespace pluvia
