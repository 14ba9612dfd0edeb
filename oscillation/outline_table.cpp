#include "oscillation/outline_table.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr double degree = std::numbers::pi / 180;

struct Column {
  const char* name = "";
  const char* quantity = "";  // a table holds each at most once
  double OutlinePoint::*member = nullptr;
  double unit = 1;
  double low = 0, high = 0;  // in the column's own unit
};

// A radius between 10 um and 20 mm holds every drop that falls; outside, the unit is wrong.
constexpr std::array<Column, 12> known_columns = {{
    {"t_s", "time", &OutlinePoint::time_s, 1, -1e4, 1e4},
    {"t_ms", "time", &OutlinePoint::time_s, 1e-3, -1e7, 1e7},
    {"theta_deg", "theta", &OutlinePoint::theta_rad, degree, -720, 720},
    {"theta_rad", "theta", &OutlinePoint::theta_rad, 1, -13, 13},
    {"r_m", "radius", &OutlinePoint::radius_m, 1, 1e-5, 2e-2},
    {"r_mm", "radius", &OutlinePoint::radius_m, 1e-3, 1e-2, 20},
    {"r_um", "radius", &OutlinePoint::radius_m, 1e-6, 10, 2e4},
    {"sigma_m", "standard error", &OutlinePoint::sigma_m, 1, 1e-12, 2e-2},
    {"sigma_mm", "standard error", &OutlinePoint::sigma_m, 1e-3, 1e-9, 20},
    {"sigma_um", "standard error", &OutlinePoint::sigma_m, 1e-6, 1e-6, 2e4},
    {"view_elevation_deg", "view elevation", &OutlinePoint::view_elevation_rad, degree, -90, 90},
    {"view_azimuth_deg", "view azimuth", &OutlinePoint::view_azimuth_rad, degree, -360, 360},
}};

[[noreturn]] void refuse(const std::string& file, int line, std::size_t column,
                         const std::string& message) {
  throw std::runtime_error(fmt::format("{}:{}:{}: {}", file, line, column, message));
}

struct Cell {
  std::string_view text = {};
  std::size_t column = 1;
};

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<Cell> cells_of(std::string_view line) {
  std::vector<Cell> cells;
  for (std::size_t at = 0;;) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    const std::string_view raw = line.substr(at, comma - at);
    const std::string_view text = trimmed(raw);
    const std::size_t skipped =
        text.empty() ? 0 : static_cast<std::size_t>(text.data() - raw.data());
    cells.push_back({text, at + skipped + 1});
    if (comma == line.size()) return cells;
    at = comma + 1;
  }
}

std::string known_names() {
  std::string names;
  for (const Column& column : known_columns)
    names += (names.empty() ? "" : ", ") + std::string(column.name);
  return names;
}

std::vector<Column> read_names(const std::string& file, int number, std::string_view line) {
  std::vector<Column> columns;
  for (const Cell& cell : cells_of(line)) {
    const auto known = std::find_if(known_columns.begin(), known_columns.end(),
                                    [&](const Column& c) { return cell.text == c.name; });
    if (known == known_columns.end()) {
      refuse(file, number, cell.column,
             fmt::format("column \"{}\"; expected one of {}", cell.text, known_names()));
    }
    for (const Column& other : columns) {
      if (std::string_view(other.quantity) != known->quantity) continue;
      refuse(file, number, cell.column,
             fmt::format("column {} after {}; expected the {} once", known->name, other.name,
                         known->quantity));
    }
    columns.push_back(*known);
  }
  for (const std::string_view needed : {"time", "theta", "radius"}) {
    if (std::none_of(columns.begin(), columns.end(),
                     [&](const Column& c) { return needed == c.quantity; })) {
      refuse(file, number, 1,
             fmt::format("no column of the {}; expected t_s, theta_deg, r_mm or "
                         "the like",
                         needed));
    }
  }
  return columns;
}

OutlinePoint read_row(const std::string& file, int number, std::string_view line,
                      const std::vector<Column>& columns) {
  const std::vector<Cell> cells = cells_of(line);
  if (cells.size() != columns.size()) {
    refuse(file, number, cells.back().column,
           fmt::format("{} values; expected {}, as many as names", cells.size(), columns.size()));
  }
  OutlinePoint point;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Column& column = columns[k];
    const std::string_view text = cells[k].text;
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    // Not a number is outside every range.
    const bool whole = error == std::errc() && end == text.data() + text.size();
    if (!whole || !(value >= column.low && value <= column.high)) {
      refuse(file, number, cells[k].column,
             fmt::format("{} = \"{}\"; expected a number, {} .. {}", column.name, text, column.low,
                         column.high));
    }
    point.*column.member = value * column.unit;
  }
  return point;
}

}  // namespace

Outlines read_outlines(const std::string& file) {
  std::ifstream in(file);
  if (!in) {
    throw std::runtime_error(fmt::format("{}: cannot read: {}; expected a table of outlines", file,
                                         std::strerror(errno)));
  }
  constexpr std::string_view source_mark = "# source:";
  Outlines outlines;
  std::vector<Column> columns;
  std::string line;
  int number = 0;
  while (std::getline(in, line)) {
    ++number;
    if (line.starts_with(source_mark)) {
      outlines.source = trimmed(std::string_view(line).substr(source_mark.size()));
    }
    if (trimmed(line).empty() || line[0] == '#') continue;
    if (columns.empty()) {
      columns = read_names(file, number, line);
    } else {
      outlines.points.push_back(read_row(file, number, line, columns));
    }
  }
  if (outlines.points.empty()) {
    refuse(file, number + 1, 1, "the end; expected a line of names and rows of numbers");
  }
  if (outlines.source.empty()) {
    refuse(file, 1, 1, "no comment \"# source: ..\"; expected one that tells who measured this");
  }
  return outlines;
}

}  // namespace pluvia
