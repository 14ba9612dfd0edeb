#include "atlas/json_place.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

nlohmann::ordered_json parse_json(const std::string& file, const std::string& text) {
  try {
    return nlohmann::ordered_json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    // error.byte counts from 1 to the last character read.
    const std::size_t end = std::min(text.size(), error.byte == 0 ? 0 : error.byte - 1);
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    const std::size_t line_start = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
    const std::size_t column = line_start == std::string::npos ? end + 1 : end - line_start;
    throw std::runtime_error(fmt::format(
        "{}:{}:{}: not JSON: unexpected character or end of file; expected a whole JSON document",
        file, line, column));
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(
        fmt::format("{}: not JSON: {}; expected numbers in range", file, error.what()));
  }
}

std::string document_text(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void throw_at(const JsonPlace& place, const std::string& found_and_expected) {
  throw std::runtime_error(
      place.path.empty() ? fmt::format("{}: {}", place.file, found_and_expected)
                         : fmt::format("{}: {}: {}", place.file, place.path, found_and_expected));
}

JsonPlace member(const JsonPlace& object, const std::string& key) {
  if (!object.value->is_object()) {
    throw_at(object, fmt::format("a JSON {}; expected an object", object.value->type_name()));
  }
  JsonPlace place = {.value = nullptr,
                     .file = object.file,
                     .path = object.path.empty() ? key : object.path + "." + key};
  const auto found = object.value->find(key);
  if (found == object.value->end()) throw_at(place, "missing; expected this key");
  place.value = &*found;
  return place;
}

std::vector<JsonPlace> elements(const JsonPlace& array) {
  if (!array.value->is_array()) {
    throw_at(array, fmt::format("a JSON {}; expected an array", array.value->type_name()));
  }
  std::vector<JsonPlace> places;
  for (const auto& value : *array.value) {
    places.push_back({.value = &value,
                      .file = array.file,
                      .path = fmt::format("{}[{}]", array.path, places.size())});
  }
  return places;
}

std::string text_at(const JsonPlace& place) {
  if (!place.value->is_string()) throw_at(place, place.value->dump() + "; expected a string");
  return place.value->get<std::string>();
}

bool truth_at(const JsonPlace& place) {
  if (!place.value->is_boolean()) throw_at(place, place.value->dump() + "; expected true or false");
  return place.value->get<bool>();
}

double number_at(const JsonPlace& place) {
  if (!place.value->is_number()) throw_at(place, place.value->dump() + "; expected a number");
  return place.value->get<double>();
}

double positive_at(const JsonPlace& place) {
  const double value = number_at(place);
  if (!(value > 0)) throw_at(place, fmt::format("{}; expected a number > 0", value));
  return value;
}

int integer_at(const JsonPlace& place, int lowest, int highest) {
  // Compared as double first: an integer beyond 64 bits is stored as one.
  const double value = number_at(place);
  if (!place.value->is_number_integer() || value < lowest || value > highest) {
    throw_at(place,
             fmt::format("{}; expected an integer {} .. {}", place.value->dump(), lowest, highest));
  }
  return place.value->get<int>();
}

void check_version(const JsonPlace& document, int version) {
  const auto* found = member(document, "version").value;
  if (*found == version) return;
  throw_at(document,
           fmt::format("version {}; this program reads version {}", found->dump(), version));
}

}  // namespace pluvia
