// The shape at which a falling drop comes to rest: r(theta) = (d/2) (1 + sum_{k=0}^{10} c_k cos k
// theta), Chuang and Beard 1990 (J. Atmos. Sci. 47, 1374), table of 15 diameters from 1 to 9 mm.
#pragma once

#include <string>
#include <vector>

namespace pluvia {

struct EquilibriumTable {
  std::vector<double> diameter_m = {};              // ascending
  std::vector<std::vector<double>> cos_terms = {};  // c_0 .. c_10 per row, theta from the top
};

// Reads data/tables/chuang_beard_1990_cn.csv: coefficients in 1e-4 with theta = 0 pointing DOWN;
// odd k are turned to theta from the top. The row of 8 mm is corrected in the file, which
// says so. Throws std::runtime_error "FILE:LINE: found; expected".
EquilibriumTable read_equilibrium_table(const std::string& file);

// Linear in diameter between rows. Below 1 mm: the 1 mm row scaled by (d / 1 mm)^2 (the flattening
// of small drops goes with the Bond number). Throws std::invalid_argument above 9 mm or for d <= 0.
std::vector<double> equilibrium_cos(const EquilibriumTable& table, double diameter_m);

}  // namespace pluvia
