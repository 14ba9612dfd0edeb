// The files that `pluvia fit` writes: JSON with a version number, written whole or not at all. What
// the data do not determine has no number in them, but a reason.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "oscillation/outline_fit.h"
#include "validate/streak_input.h"

namespace pluvia {

// {"name", "identifiable", "value", "low", "high", "digits"}, or {.., "why"}: one object each.
nlohmann::ordered_json estimates_json(const std::vector<Estimate>& values);

void write_outline_fit(const std::string& file, const Outlines& outlines, const OutlineFit& fit);

// source: the file of the streaks.
void write_streak_fit(const std::string& file, const std::string& source, const StreakInput& input,
                      const StreakFit& fit);

// One line for people: "A20 0.1102 (0.1098 .. 0.1106), 2.4 digits".
std::string estimate_line(const Estimate& estimate);

}  // namespace pluvia
