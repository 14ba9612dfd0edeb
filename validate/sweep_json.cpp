#include "validate/sweep_json.h"

#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"

namespace pluvia {
namespace {

using Json = nlohmann::ordered_json;
using Pairs = std::vector<std::pair<std::string, std::string>>;

Json pairs_json(const Pairs& pairs) {
  Json object = Json::object();
  for (const auto& [name, text] : pairs) object[name] = text;
  return object;
}

Json point_json(const SweepPoint& point) {
  Json also = Json::object();
  for (const auto& [name, value] : point.also) also[name] = value;
  return {{"series", point.series},
          {"setting", point.setting},
          {"flags", point.flags},
          {"time_s", point.time_s},
          {"low_s", point.low_s},
          {"high_s", point.high_s},
          {"error", point.error},
          {"standard_error", point.standard_error},
          {"noise", point.noise},
          {"on_front", point.on_front},
          {"also", also}};
}

Json curve_json(const SweepCurve& curve) {
  Json points = Json::array();
  for (const SweepPoint& point : curve.points) points.push_back(point_json(point));
  return {{"name", curve.name},
          {"title", curve.title},
          {"time_label", curve.time_label},
          {"error_label", curve.error_label},
          {"text", curve.text},
          {"whole", curve.whole},
          {"whole_factor", curve.whole_factor},
          {"standard", curve.standard},
          {"recommended", curve.recommended},
          {"why", curve.why},
          {"points", points}};
}

// The object's names and places.
std::vector<std::pair<std::string, JsonPlace>> members(const JsonPlace& place) {
  if (!place.value->is_object()) {
    throw_at(place, fmt::format("a JSON {}; expected an object", place.value->type_name()));
  }
  std::vector<std::pair<std::string, JsonPlace>> all;
  for (const auto& item : place.value->items())
    all.emplace_back(item.key(), member(place, item.key()));
  return all;
}

SweepPoint read_point(const JsonPlace& place) {
  SweepPoint point = {.series = text_at(member(place, "series")),
                      .setting = text_at(member(place, "setting")),
                      .flags = text_at(member(place, "flags")),
                      .time_s = number_at(member(place, "time_s")),
                      .low_s = number_at(member(place, "low_s")),
                      .high_s = number_at(member(place, "high_s")),
                      .error = number_at(member(place, "error")),
                      .standard_error = number_at(member(place, "standard_error")),
                      .noise = number_at(member(place, "noise"))};
  for (const auto& [name, value] : members(member(place, "also")))
    point.also.emplace_back(name, number_at(value));
  return point;
}

// As mark_front finds the front; what it says wrong about them is said of the place.
void check_front(const JsonPlace& place, SweepCurve& curve) {
  try {
    mark_front(curve);
  } catch (const std::runtime_error& error) {
    throw_at(place, error.what());
  }
  const std::vector<JsonPlace> points = elements(member(place, "points"));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const JsonPlace front = member(points[i], "on_front");
    if (*front.value == curve.points[i].on_front) continue;
    throw_at(front, fmt::format("{}; expected {} by the times and errors of all points",
                                front.value->dump(), curve.points[i].on_front));
  }
  const SweepPoint* recommended = find_setting(curve, curve.recommended);
  if (curve.recommended.empty() || (recommended != nullptr && recommended->on_front)) return;
  throw_at(member(place, "recommended"),
           fmt::format("\"{}\"; expected a setting on the front", curve.recommended));
}

SweepCurve read_curve(const JsonPlace& place) {
  SweepCurve curve = {.name = text_at(member(place, "name")),
                      .title = text_at(member(place, "title")),
                      .time_label = text_at(member(place, "time_label")),
                      .error_label = text_at(member(place, "error_label")),
                      .text = text_at(member(place, "text")),
                      .whole = text_at(member(place, "whole")),
                      .whole_factor = positive_at(member(place, "whole_factor")),
                      .standard = text_at(member(place, "standard")),
                      .recommended = text_at(member(place, "recommended")),
                      .why = text_at(member(place, "why"))};
  for (const JsonPlace& point : elements(member(place, "points"))) {
    curve.points.push_back(read_point(point));
  }
  check_front(place, curve);
  return curve;
}

Pairs read_pairs(const JsonPlace& place) {
  Pairs pairs;
  for (const auto& [name, value] : members(place)) pairs.emplace_back(name, text_at(value));
  return pairs;
}

std::vector<std::string> read_texts(const JsonPlace& place) {
  std::vector<std::string> texts;
  for (const JsonPlace& text : elements(place)) texts.push_back(text_at(text));
  return texts;
}

}  // namespace

std::string sweep_json(const Sweep& sweep) {
  Json curves = Json::array();
  for (const SweepCurve& curve : sweep.curves) curves.push_back(curve_json(curve));
  const Json root = {{"version", 1},
                     {"curves", curves},
                     {"machine", pairs_json(sweep.machine)},
                     {"seeds", pairs_json(sweep.seeds)},
                     {"commands", sweep.commands},
                     {"skipped", sweep.skipped}};
  // A name from outside may hold bytes that are no UTF-8: they become U+FFFD, not an exception.
  return document_text(root, 2);
}

Sweep read_sweep(const std::string& file) {
  const Json json = parse_json(file, read_file(file));
  const JsonPlace document = {.value = &json, .file = file};
  check_version(document, 1);
  Sweep sweep = {.machine = read_pairs(member(document, "machine")),
                 .seeds = read_pairs(member(document, "seeds")),
                 .commands = read_texts(member(document, "commands")),
                 .skipped = read_texts(member(document, "skipped"))};
  std::map<std::string, std::string> places;
  for (const JsonPlace& place : elements(member(document, "curves"))) {
    sweep.curves.push_back(read_curve(place));
    const auto [earlier, is_new] = places.emplace(sweep.curves.back().name, place.path);
    if (is_new) continue;
    throw_at(member(place, "name"), fmt::format("\"{}\" as in {}; expected each name once",
                                                sweep.curves.back().name, earlier->second));
  }
  return sweep;
}

}  // namespace pluvia
