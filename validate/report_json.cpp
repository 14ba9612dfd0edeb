#include <nlohmann/json.hpp>

#include "atlas/json_place.h"
#include "validate/report_parts.h"

namespace pluvia {
namespace {

using Json = nlohmann::ordered_json;

// Not a number and infinity become null when the text is made: JSON has neither.
Json check_json(const Check& check) {
  return {{"name", check.name},
          {"value", check.value},
          {"bound", check.bound},
          {"measured", check.measured},
          {"expected", check.expected},
          {"unit", check.unit},
          {"pass", passes(check)},
          {"uncertainty", check.uncertainty},
          {"why", check.why}};
}

}  // namespace

std::string report_json(const Report& report) {
  Json checks = Json::array();
  for (const Check& check : report.checks) checks.push_back(check_json(check));
  Json timings = Json::object();
  for (const auto& [name, seconds] : report.timings_s) {
    timings[name] = timings.value(name, 0.0) + seconds;
  }
  Json machine = Json::object();
  for (const auto& [name, text] : report.machine) machine[name] = text;
  Json seeds = Json::object();
  for (const auto& [name, text] : report.seeds) seeds[name] = text;
  const Json root = {{"version", 1},
                     {"checks", checks},
                     {"timings_s", timings},
                     {"machine", machine},
                     {"seeds", seeds},
                     {"commands", report.commands},
                     {"skipped", report.skipped},
                     {"not_covered", report.not_covered}};
  // A name from outside may hold bytes that are no UTF-8: they become U+FFFD, not an exception.
  return document_text(root, 2);
}

}  // namespace pluvia
