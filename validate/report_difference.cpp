#include "validate/report_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

// null is what the report writes for NaN and infinity.
double number_or_nan(const JsonPlace& place) {
  return place.value->is_null() ? std::numeric_limits<double>::quiet_NaN() : number_at(place);
}

Check read_check(const JsonPlace& place) {
  const Check check = {.name = text_at(member(place, "name")),
                       .value = number_or_nan(member(place, "value")),
                       .bound = number_or_nan(member(place, "bound")),
                       .measured = number_or_nan(member(place, "measured")),
                       .expected = number_or_nan(member(place, "expected")),
                       .uncertainty = number_or_nan(member(place, "uncertainty")),
                       .unit = text_at(member(place, "unit")),
                       .why = text_at(member(place, "why"))};
  const JsonPlace pass = member(place, "pass");
  if (*pass.value != passes(check)) {
    throw_at(pass, fmt::format("{}; expected {}: value {}, bound {}", pass.value->dump(),
                               passes(check), number_text(check.value), number_text(check.bound)));
  }
  return check;
}

double value_of(const Check& check) {
  return std::isfinite(check.value) ? check.value : std::numeric_limits<double>::infinity();
}

double uncertainty_of_value(const Check& check) {
  const double difference = std::abs(check.measured - check.expected);
  const double scale = difference > 0 ? check.value / difference : 1;
  const double result = check.uncertainty * scale;
  return std::isfinite(result) ? result : 0;
}

// The larger bound: a bound that was moved is no reason to call less a change.
double margin_of(const Check& before, const Check& after) {
  const double bound = std::fmax(before.bound, after.bound);
  return 2 * std::hypot(uncertainty_of_value(before), uncertainty_of_value(after)) +
         0.01 * (std::isfinite(bound) ? bound : 0);
}

// Puts the change of a check that is in both reports at the end of the list, if there is one.
void add_change(const Check& before, const Check& after, std::vector<CheckChange>& changes) {
  CheckChange change = {.before = before, .after = after, .margin = margin_of(before, after)};
  const double from = value_of(before), to = value_of(after);
  if (passes(before) != passes(after)) {
    change.change = passes(after) ? Change::passes_now : Change::fails_now;
  } else if (to > from + change.margin) {
    change.change = Change::worse;
  } else if (to < from - change.margin) {
    change.change = Change::better;
  } else {
    return;
  }
  changes.push_back(change);
}

const char* word(Change change) {
  switch (change) {
    case Change::fails_now:
      return "fails now";
    case Change::worse:
      return "worse";
    case Change::better:
      return "better";
    case Change::passes_now:
      return "passes now";
    case Change::appeared:
      return "new";
    case Change::gone:
      return "gone";
  }
  return "";
}

}  // namespace

std::vector<Check> read_report_checks(const std::string& file) {
  const nlohmann::ordered_json json = parse_json(file, read_file(file));
  const JsonPlace document = {.value = &json, .file = file};
  check_version(document, 1);
  std::vector<Check> checks;
  std::map<std::string, std::string> places;
  for (const JsonPlace& place : elements(member(document, "checks"))) {
    checks.push_back(read_check(place));
    const auto [earlier, is_new] = places.emplace(checks.back().name, place.path);
    if (!is_new) {
      throw_at(member(place, "name"), fmt::format("\"{}\" as in {}; expected each name once",
                                                  checks.back().name, earlier->second));
    }
  }
  return checks;
}

std::vector<CheckChange> report_difference(const std::vector<Check>& before,
                                           const std::vector<Check>& after) {
  const auto find = [](const std::vector<Check>& list, const Check& wanted) {
    return std::find_if(list.begin(), list.end(),
                        [&](const Check& check) { return check.name == wanted.name; });
  };
  std::vector<CheckChange> changes;
  for (const Check& check : after) {
    const auto old = find(before, check);
    if (old == before.end()) {
      changes.push_back({.change = Change::appeared, .after = check});
    } else {
      add_change(*old, check, changes);
    }
  }
  for (const Check& check : before) {
    if (find(after, check) == after.end()) {
      changes.push_back({.change = Change::gone, .before = check});
    }
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const CheckChange& a, const CheckChange& b) { return a.change < b.change; });
  return changes;
}

bool is_regression(const CheckChange& change) {
  return change.change == Change::fails_now || change.change == Change::worse;
}

std::string change_line(const CheckChange& change) {
  const bool gone = change.change == Change::gone, appeared = change.change == Change::appeared;
  const Check& check = gone ? change.before : change.after;
  const std::string start = fmt::format("{:<11} {:<32} ", word(change.change), check.name);
  if (gone || appeared) {
    return start + fmt::format("{} {} ({} at a bound of {})", number_text(check.value), check.unit,
                               passes(check) ? "passes" : "fails", number_text(check.bound));
  }
  return start + fmt::format("{} -> {} {} (margin {}, bound {})", number_text(change.before.value),
                             number_text(check.value), check.unit, number_text(change.margin),
                             number_text(check.bound));
}

}  // namespace pluvia
