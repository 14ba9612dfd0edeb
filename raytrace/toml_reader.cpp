#include "raytrace/toml_reader.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pluvia {
namespace {

std::string place(const std::string& file, const toml::source_position& position) {
  return fmt::format("{}:{}:{}", file, position.line, position.column);
}

// A value as a message quotes it.
std::string quoted(const toml::node& node) {
  if (const auto* text = node.as_string()) return fmt::format("\"{}\"", text->get());
  if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* list = node.as_array()) return fmt::format("an array of {} values", list->size());
  if (node.is_table()) return "a table";
  return "a date or time";
}

std::string expected_range(const std::string& key, const Range& range, const char* unit) {
  const bool below = range.low > -1e300, above = range.high < 1e300;
  std::string text = "a finite number";
  if (below && above)
    text = fmt::format("{} {} {} <= {}", range.low, range.low_open ? "<" : "<=", key, range.high);
  else if (below)
    text = fmt::format("{} {} {}", key, range.low_open ? ">" : ">=", range.low);
  else if (above)
    text = fmt::format("{} <= {}", key, range.high);
  return *unit ? text + " " + unit : text;
}

std::string expected_integer(const std::string& key, int low, int high) {
  return fmt::format("an integer, {} <= {} <= {}", low, key, high);
}

// Levenshtein's distance: inserted, removed and replaced letters between two keys.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string read_text(const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw std::runtime_error(
        fmt::format("{}: cannot read: is a directory; expected a readable TOML file", file));
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad())
    throw std::runtime_error(fmt::format("{}: cannot read: {}; expected a readable TOML file", file,
                                         std::strerror(errno ? errno : EIO)));
  return text;
}

}  // namespace

toml::table read_toml(const std::string& file) {
  const std::string text = read_text(file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    std::string what(error.description());
    std::replace(what.begin(), what.end(), '\n', ' ');
    throw std::runtime_error(
        fmt::format("{}: {}; expected valid TOML", place(file, error.source().begin), what));
  }
}

TomlReader::TomlReader(const toml::table& table, std::string file, std::string name)
    : table_(&table), file_(std::move(file)), name_(std::move(name)) {}

std::string TomlReader::full_name(const std::string& key) const {
  return name_.empty() ? key : name_ + "." + key;
}

void TomlReader::refuse(const char* key, const std::string& message) const {
  toml::source_position position = table_->source().begin;
  if (const auto found = table_->find(key); found != table_->cend())
    position = found->first.source().begin;
  throw std::runtime_error(fmt::format("{}: {}", place(file_, position), message));
}

void TomlReader::refuse_value(const char* key, const std::string& found,
                              const std::string& expected) const {
  refuse(key, fmt::format("{}; expected {}", found, expected));
}

const toml::node* TomlReader::find(const char* key) {
  known_.emplace_back(key);
  return table_->get(key);
}

const toml::node& TomlReader::find_required(const char* key, const std::string& expected) {
  const toml::node* node = find(key);
  if (!node) refuse_value(key, full_name(key) + " is missing", expected);
  return *node;
}

double TomlReader::number(const char* key, const toml::node& node, const Range& range,
                          const std::string& expected, const std::string& suffix) const {
  const bool is_number = node.is_integer() || node.is_floating_point();
  const double value = is_number ? *node.value<double>() : std::numeric_limits<double>::quiet_NaN();
  const bool above = range.low_open ? value > range.low : value >= range.low;
  if (!std::isfinite(value) || !above || value > range.high)
    refuse_value(key, fmt::format("{}{} = {}", full_name(key), suffix, quoted(node)), expected);
  return value;
}

int TomlReader::integer(const char* key, const toml::node& node, int low, int high,
                        const std::string& suffix) const {
  const auto* value = node.as_integer();
  if (!value || value->get() < low || value->get() > high)
    refuse_value(key, fmt::format("{}{} = {}", full_name(key), suffix, quoted(node)),
                 expected_integer(key + suffix, low, high));
  return static_cast<int>(value->get());
}

Eigen::Vector3d TomlReader::vector(const char* key, const toml::node& node,
                                   const Range& range) const {
  const auto* list = node.as_array();
  if (!list || list->size() != 3)
    refuse_value(key, full_name(key) + " = " + quoted(node), "an array of 3 numbers");
  Eigen::Vector3d value;
  for (int i = 0; i < 3; ++i) {
    const std::string suffix = fmt::format("[{}]", i);
    value[i] = number(key, *list->get(static_cast<std::size_t>(i)), range,
                      expected_range(key + suffix, range, ""), suffix);
  }
  return value;
}

void TomlReader::required(const char* key, double& value, const Range& range, const char* unit) {
  const std::string expected = expected_range(key, range, unit);
  value = number(key, find_required(key, expected), range, expected);
}

void TomlReader::optional(const char* key, double& value, const Range& range, const char* unit) {
  if (const auto* node = find(key))
    value = number(key, *node, range, expected_range(key, range, unit));
}

void TomlReader::required(const char* key, int& value, int low, int high) {
  value = integer(key, find_required(key, expected_integer(key, low, high)), low, high);
}

void TomlReader::optional(const char* key, int& value, int low, int high) {
  if (const auto* node = find(key)) value = integer(key, *node, low, high);
}

void TomlReader::optional(const char* key, unsigned long long& value) {
  const auto* node = find(key);
  if (!node) return;
  const auto* integer = node->as_integer();
  if (!integer || integer->get() < 0)
    refuse_value(key, full_name(key) + " = " + quoted(*node),
                 fmt::format("an integer, {} >= 0", key));
  value = static_cast<unsigned long long>(integer->get());
}

void TomlReader::optional(const char* key, bool& value) {
  const auto* node = find(key);
  if (!node) return;
  if (!node->is_boolean())
    refuse_value(key, full_name(key) + " = " + quoted(*node), "true or false");
  value = node->as_boolean()->get();
}

void TomlReader::required(const char* key, std::string& value) {
  find_required(key, "a string in quotes");
  optional(key, value);
}

void TomlReader::optional(const char* key, std::string& value) {
  const auto* node = find(key);
  if (!node) return;
  if (!node->is_string())
    refuse_value(key, full_name(key) + " = " + quoted(*node), "a string in quotes");
  value = node->as_string()->get();
}

void TomlReader::required(const char* key, Eigen::Vector3d& value, const Range& range) {
  value = vector(key, find_required(key, "an array of 3 numbers"), range);
}

void TomlReader::optional(const char* key, Eigen::Vector3d& value, const Range& range) {
  if (const auto* node = find(key)) value = vector(key, *node, range);
}

void TomlReader::optional(const char* key, std::vector<int>& value, int low, int high) {
  const auto* node = find(key);
  if (!node) return;
  const auto* list = node->as_array();
  if (!list)
    refuse_value(key, full_name(key) + " = " + quoted(*node),
                 fmt::format("an array of integers {} .. {}", low, high));
  std::vector<int> values;
  for (std::size_t i = 0; i < list->size(); ++i)
    values.push_back(integer(key, *list->get(i), low, high, fmt::format("[{}]", i)));
  value = std::move(values);
}

void TomlReader::required(const char* key, std::vector<double>& value, const Range& range,
                          const char* unit) {
  const std::string expected =
      fmt::format("an array of numbers, {}", expected_range(key, range, unit));
  const toml::node& node = find_required(key, expected);
  const auto* list = node.as_array();
  if (!list) refuse_value(key, full_name(key) + " = " + quoted(node), expected);
  std::vector<double> values;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string suffix = fmt::format("[{}]", i);
    values.push_back(
        number(key, *list->get(i), range, expected_range(key + suffix, range, unit), suffix));
  }
  value = std::move(values);
}

bool TomlReader::has(const char* key) {
  return find(key) != nullptr;
}

TomlReader TomlReader::table(const char* key) {
  const std::string expected = fmt::format("a table [{}]", full_name(key));
  const toml::node& node = find_required(key, expected);
  if (!node.is_table()) refuse_value(key, full_name(key) + " = " + quoted(node), expected);
  return TomlReader(*node.as_table(), file_, full_name(key));
}

std::vector<TomlReader> TomlReader::tables(const char* key) {
  const auto* node = find(key);
  std::vector<TomlReader> readers;
  if (!node) return readers;
  const auto* list = node->as_array();
  const bool all_tables =
      list && std::all_of(list->cbegin(), list->cend(), [](auto& n) { return n.is_table(); });
  if (!all_tables)
    refuse_value(key, full_name(key) + " = " + quoted(*node),
                 fmt::format("tables [[{}]]", full_name(key)));
  for (std::size_t i = 0; i < list->size(); ++i)
    readers.emplace_back(*list->get_as<toml::table>(i), file_,
                         fmt::format("{}[{}]", full_name(key), i));
  return readers;
}

void TomlReader::finish() const {
  const toml::key* unknown = nullptr;
  for (const auto& [key, node] : *table_) {
    const std::string name(key.str());
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    if (!unknown || key.source().begin < unknown->source().begin) unknown = &key;
  }
  if (!unknown) return;
  const std::string name(unknown->str());
  const auto nearest =
      std::min_element(known_.begin(), known_.end(), [&](const auto& a, const auto& b) {
        return edit_distance(name, a) < edit_distance(name, b);
      });
  // Farther than half its letters it is no misspelling: list what there is.
  const bool near = nearest != known_.end() && edit_distance(name, *nearest) <= name.size() / 2;
  const std::string hint = near ? fmt::format("did you mean \"{}\"?", *nearest)
                                : fmt::format("expected one of {}", fmt::join(known_, ", "));
  const std::string where = name_.empty() ? "" : fmt::format(" in [{}]", name_);
  throw std::runtime_error(fmt::format("{}: unknown key \"{}\"{}; {}",
                                       place(file_, unknown->source().begin), name, where, hint));
}

std::string path_beside(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).string();
}

}  // namespace pluvia
