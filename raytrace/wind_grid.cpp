#include "raytrace/wind_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pluvia {

WindGrid make_wind_grid(const Wind& steady, const Eigen::Vector3d& low_m,
                        const Eigen::Vector3d& high_m, const TopHeight& top, int nodes) {
  WindGrid grid = {.low_m = low_m, .step_m = (high_m - low_m) / (nodes - 1), .nodes = nodes};
  const auto n = static_cast<std::size_t>(nodes);
  grid.wind_m_s.assign(n * n * n, Eigen::Vector3d(0, 0, 0));
  const auto place = [&](int x, int y, int z) -> Eigen::Vector3d {
    return low_m + grid.step_m.cwiseProduct(Eigen::Vector3d(x, y, z));
  };
  const auto fill_column = [&](int x, int y) {
    const Eigen::Vector3d foot = place(x, y, 0);
    const double surface_m = height_at(top, foot.x(), foot.y());
    for (int z = 0; z < nodes; ++z) {
      const Eigen::Vector3d at = place(x, y, z);
      if (at.z() > surface_m) grid.wind_m_s[node_index(grid, x, y, z)] = velocity_m_s(steady, at);
    }
  };
  for (int y = 0; y < nodes; ++y) {
    for (int x = 0; x < nodes; ++x) fill_column(x, y);
  }
  return grid;
}

Eigen::Vector3d velocity_m_s(const WindGrid& grid, const Eigen::Vector3d& at_m) {
  std::array<int, 3> first = {};
  std::array<double, 3> share = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double at = std::clamp((at_m[axis] - grid.low_m[axis]) / grid.step_m[axis], 0.0,
                                 static_cast<double>(grid.nodes - 1));
    first[i] = std::min(static_cast<int>(at), grid.nodes - 2);
    share[i] = at - first[i];
  }
  Eigen::Vector3d sum(0, 0, 0);
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const double weight = (x ? share[0] : 1 - share[0]) * (y ? share[1] : 1 - share[1]) *
                          (z ? share[2] : 1 - share[2]);
    sum += weight * grid.wind_m_s[node_index(grid, first[0] + x, first[1] + y, first[2] + z)];
  }
  return sum;
}

}  // namespace pluvia
