// Reads the numbers of data/tables/*.csv for tests.
#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pluvia {

// Rows of cells after the comments and the line of names; quotes are dropped. Empty when the file
// cannot be read: tests expect rows.
inline std::vector<std::vector<std::string>> table_rows(const std::string& name) {
  std::ifstream in(std::string(PLUVIA_SOURCE_DIR) + "/data/tables/" + name);
  std::vector<std::vector<std::string>> rows;
  std::string line;
  bool names = true;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    if (std::exchange(names, false)) continue;
    std::vector<std::string> cells;
    std::stringstream cell_stream(line);
    std::string cell;
    while (std::getline(cell_stream, cell, ',')) {
      std::erase(cell, '"');
      cells.push_back(cell);
    }
    rows.push_back(cells);
  }
  return rows;
}

}  // namespace pluvia
