#include "realtime/light_candidates.h"

#include <algorithm>
#include <cmath>

namespace pluvia {
namespace {

Eigen::Vector3d unfolded(double x, double y) {
  Eigen::Vector3d d(x, y, 1 - std::abs(x) - std::abs(y));
  if (d.z() < 0) {
    d.x() = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
    d.y() = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
  }
  return d.normalized();
}

}  // namespace

int candidates_cell(const Eigen::Vector3d& direction) {
  Eigen::Vector2d square = direction.head<2>() / direction.lpNorm<1>();
  if (direction.z() < 0)
    square = Eigen::Vector2d((1 - std::abs(square.y())) * (square.x() < 0 ? -1 : 1),
                             (1 - std::abs(square.x())) * (square.y() < 0 ? -1 : 1));
  const auto place = [](double along) {
    return std::clamp(static_cast<int>(0.5 * (along + 1) * candidate_cells), 0,
                      candidate_cells - 1);
  };
  return place(square.y()) * candidate_cells + place(square.x());
}

std::vector<std::uint32_t> light_candidates(const std::vector<Eigen::Vector3d>& lights) {
  constexpr int cells = candidate_cells * candidate_cells;
  constexpr double step = 2.0 / candidate_cells;
  std::vector<std::uint32_t> table(cells + 1);
  for (int cell = 0; cell < cells; ++cell) {
    const double x = -1 + (cell % candidate_cells + 0.5) * step;
    const double y = -1 + (cell / candidate_cells + 0.5) * step;
    const Eigen::Vector3d centre = unfolded(x, y);
    // A side of a cell is no longer than the cell is from its centre to a corner; half as much
    // again covers what bulges between the corners, and float.
    double reach = 0;
    for (const double dx : {-0.5, 0.5}) {
      for (const double dy : {-0.5, 0.5})
        reach = std::max(reach, (unfolded(x + dx * step, y + dy * step) - centre).norm());
    }
    double least = 2;
    for (const Eigen::Vector3d& light : lights) least = std::min(least, (light - centre).norm());
    table[static_cast<std::size_t>(cell)] = static_cast<std::uint32_t>(table.size());
    // Chords obey the triangle's inequality.
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if ((lights[i] - centre).norm() <= least + 2 * 1.5 * reach + 1e-3)
        table.push_back(static_cast<std::uint32_t>(i));
    }
  }
  table[cells] = static_cast<std::uint32_t>(table.size());
  return table;
}

}  // namespace pluvia
