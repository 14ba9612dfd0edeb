#include "oscillation/equilibrium.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr int term_count = 11;

std::vector<double> parse_row(const std::string& line, const std::string& place) {
  std::vector<double> values;
  const char* at = line.data();
  const char* const end = line.data() + line.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value) || (next != end && *next != ',')) {
      throw std::runtime_error(fmt::format("{}: \"{}\"; expected finite numbers between commas",
                                           place, std::string(at, end).substr(0, 20)));
    }
    values.push_back(value);
    at = next + 1;
  }
  if (values.size() < term_count + 1) {
    throw std::runtime_error(fmt::format("{}: {} columns; expected at least {}: d_mm, c0 .. c10",
                                         place, values.size(), term_count + 1));
  }
  return values;
}

}  // namespace

EquilibriumTable read_equilibrium_table(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot read; expected a table of c_0 .. c_10");
  EquilibriumTable table;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#' || line[0] == 'd') continue;
    const auto row = parse_row(line, fmt::format("{}:{}", file, number));
    std::vector<double> terms;
    for (int k = 0; k < term_count; ++k) {
      const double c = row[static_cast<std::size_t>(k) + 1] * 1e-4;
      terms.push_back(k % 2 == 1 ? -c : c);
    }
    if (!(row[0] > 0)) {
      throw std::runtime_error(
          fmt::format("{}:{}: d = {} mm; expected d > 0", file, number, row[0]));
    }
    if (!table.diameter_m.empty() && row[0] * 1e-3 <= table.diameter_m.back()) {
      throw std::runtime_error(
          fmt::format("{}:{}: d = {} mm; expected ascending diameters", file, number, row[0]));
    }
    table.diameter_m.push_back(row[0] * 1e-3);
    table.cos_terms.push_back(std::move(terms));
  }
  if (table.diameter_m.size() < 2) {
    throw std::runtime_error(file + ": fewer than two rows; expected a table of c_0 .. c_10");
  }
  return table;
}

std::vector<double> equilibrium_cos(const EquilibriumTable& table, double diameter_m) {
  const auto& d = table.diameter_m;
  if (!(diameter_m > 0 && diameter_m <= d.back())) {
    throw std::invalid_argument(
        fmt::format("diameter_m = {}; expected 0 < diameter_m <= {}", diameter_m, d.back()));
  }
  std::vector<double> terms = table.cos_terms.front();
  if (diameter_m <= d.front()) {
    for (double& c : terms) c *= std::pow(diameter_m / d.front(), 2);
    return terms;
  }
  const auto above =
      static_cast<std::size_t>(std::lower_bound(d.begin(), d.end(), diameter_m) - d.begin());
  const double w = (diameter_m - d[above - 1]) / (d[above] - d[above - 1]);
  for (std::size_t k = 0; k < terms.size(); ++k) {
    terms[k] = (1 - w) * table.cos_terms[above - 1][k] + w * table.cos_terms[above][k];
  }
  return terms;
}

}  // namespace pluvia
