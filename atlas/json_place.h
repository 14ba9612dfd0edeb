// Reading JSON with messages that tell the place: "FILE: KEY: found; expected". A place is a value
// with the path that led to it, such as shards[3].sha256.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace pluvia {

struct JsonPlace {
  const nlohmann::ordered_json* value = nullptr;  // must outlive the place
  std::string file = {};
  std::string path = {};  // empty: the whole document
};

// Throws std::runtime_error "FILE:LINE:COL: not JSON: ..".
nlohmann::ordered_json parse_json(const std::string& file, const std::string& text);

// Each throws std::runtime_error where the value is missing, of another type or out of range.
JsonPlace member(const JsonPlace& object, const std::string& key);
std::vector<JsonPlace> elements(const JsonPlace& array);
std::string text_at(const JsonPlace& place);
bool truth_at(const JsonPlace& place);
double number_at(const JsonPlace& place);
double positive_at(const JsonPlace& place);
int integer_at(const JsonPlace& place, int lowest, int highest);

// The document's "version": "FILE: version 3; this program reads version 1".
void check_version(const JsonPlace& document, int version);

// A document as a file's text. A name from outside may hold bytes that are no UTF-8: they are
// replaced, for work that is finished must not be lost to them.
std::string document_text(const nlohmann::ordered_json& document, int indent);

[[noreturn]] void throw_at(const JsonPlace& place, const std::string& found_and_expected);

}  // namespace pluvia
