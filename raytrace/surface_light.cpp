#include "raytrace/surface_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raytrace/spherical_harmonics.h"

namespace pluvia {

namespace {

constexpr std::size_t places = cell_side * cell_side;

// Weights of the cubic through values at 0, 1, 2, 3.
std::array<double, cell_side> cubic_weights(double s) {
  return {-(s - 1) * (s - 2) * (s - 3) / 6, s * (s - 2) * (s - 3) / 2, -s * (s - 1) * (s - 3) / 2,
          s * (s - 1) * (s - 2) / 6};
}

// Values under each environment of light from one direction.
void direction_values(const Eigen::Vector3d& direction, const EnvironmentRequest& request,
                      std::span<double> values) {
  const std::size_t transfer = transfer_count(request);
  if (transfer > 0) {
    real_harmonics(request.transfer_degree, direction, values.first(transfer));
  }
  if (map_count(request) > 0) look_up(request.map, direction, values.subspan(transfer));
}

}  // namespace

std::size_t transfer_count(const EnvironmentRequest& request) {
  return request.transfer_degree < 0 ? 0 : harmonic_count(request.transfer_degree);
}

std::size_t map_count(const EnvironmentRequest& request) {
  return request.map.radiance.values.empty()
             ? 0
             : static_cast<std::size_t>(request.map.radiance.channels);
}

std::size_t value_count(const EnvironmentRequest& request) {
  return transfer_count(request) + map_count(request);
}

void node_values(const ExitField& field, std::uint32_t node, const EnvironmentRequest& request,
                 std::span<double> values) {
  std::fill(values.begin(), values.end(), 0.0);
  std::vector<double> one(values.size());
  const FieldNode& n = field.nodes[node];
  for (std::uint32_t e = 0; e < n.exit_count; ++e) {
    const PathExit& exit = field.exits[n.first_exit + e];
    const bool beyond = n.facing <= 0;
    if (beyond ? exit.order != 0 : exit.throughput <= 0) continue;
    const double throughput = beyond ? 1 : exit.throughput;
    direction_values(exit.direction, request, one);
    for (std::size_t k = 0; k < one.size(); ++k) values[k] += throughput * one[k];
  }
}

CellValues cell_values(const ExitField& field, const FieldCell& cell,
                       const EnvironmentRequest& request) {
  const auto count = static_cast<Eigen::Index>(value_count(request));
  const auto nodes = static_cast<Eigen::Index>(places) * field.times;
  CellValues values = {.times = field.times, .nodes = ValueRows(nodes, count)};
  for (Eigen::Index n = 0; n < nodes; ++n) {
    node_values(field, cell.nodes[static_cast<std::size_t>(n)], request,
                {values.nodes.row(n).data(), static_cast<std::size_t>(count)});
  }
  return values;
}

ValueRows CellValues::grid(double share, std::size_t steps) const {
  ValueRows now = nodes.topRows(places);
  if (times > 1) {
    const auto w = cubic_weights((cell_side - 1) * share);
    now *= w[0];
    for (std::size_t k = 1; k < cell_side; ++k) {
      now += w[k] * nodes.middleRows(static_cast<Eigen::Index>(places * k), places);
    }
  }
  const std::size_t side = steps + 1;
  ValueRows weights(static_cast<Eigen::Index>(side * side), static_cast<Eigen::Index>(places));
  for (std::size_t g = 0; g < side * side; ++g) {
    const auto at = [&](std::size_t step) {
      return cubic_weights(static_cast<double>((cell_side - 1) * step) /
                           static_cast<double>(steps));
    };
    const auto u = at(g % side), v = at(g / side);
    for (std::size_t n = 0; n < places; ++n) {
      weights(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(n)) =
          u[n % cell_side] * v[n / cell_side];
    }
  }
  return weights * now;
}

ValueRows CellValues::loose(const ExitField& field, const FieldCell& cell, std::size_t before,
                            double share) const {
  ValueRows now = nodes.middleRows(static_cast<Eigen::Index>(places * before), places);
  if (times == 1) return now;
  for (std::size_t n = 0; n < places; ++n) {
    const auto row = static_cast<Eigen::Index>(n);
    const auto after = nodes.row(static_cast<Eigen::Index>(places * (before + 1) + n));
    const bool here = field.nodes[cell.nodes[places * before + n]].known;
    const bool there = field.nodes[cell.nodes[places * (before + 1) + n]].known;
    if (here && there) {
      now.row(row) += share * (after - now.row(row));
    } else if (share >= 0.5) {
      now.row(row) = after;
    }
  }
  return now;
}

ValueDeposit make_value_deposit(const StreakWindow& window, std::size_t count) {
  ValueDeposit many = {.corners = window, .count = count};
  const auto pixels =
      static_cast<std::size_t>(window.rows) * static_cast<std::size_t>(window.width_px);
  many.corners.planes = 3;
  many.corners.values.assign(3 * pixels, 0.0);
  many.sums.assign(count * pixels, 0.0);
  return many;
}

void ValueDeposit::add(const Travel& travel, const ConePolygon& polygon, double weight,
                       const std::array<const double*, 3>& values) {
  if (polygon.count < 3) return;
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
  constexpr std::array<double ConeVertex::*, 3> shares = {&ConeVertex::dx, &ConeVertex::dy,
                                                          &ConeVertex::dz};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    ConePolygon part = polygon;
    for (int i = 0; i < part.count; ++i) {
      ConeVertex& p = part.vertices[static_cast<std::size_t>(i)];
      p.throughput = p.*shares[corner];
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      low = std::min(low, p.y);
      high = std::max(high, p.y);
    }
    deposit(corners, static_cast<int>(corner), travel, part, weight);
  }
  // A row to either side: deposit() widens what is narrower than a hundredth of a row.
  const auto pixel = [](double x) { return static_cast<int>(std::floor(x)); };
  const int last_row =
      std::min(corners.rows - 1, pixel(high + travel.last_row) + 1 - corners.first_row);
  const int last_column = std::min(corners.width_px - 1, pixel(right));
  for (int r = std::max(0, pixel(low + travel.first_row) - 1 - corners.first_row); r <= last_row;
       ++r) {
    for (int c = std::max(0, pixel(left)); c <= last_column; ++c) {
      std::array<double, 3> share;
      for (std::size_t k = 0; k < 3; ++k) {
        share[k] = std::exchange(corners.row(static_cast<int>(k), r)[c], 0.0);
      }
      double* sum = sums.data() + count * static_cast<std::size_t>(r * corners.width_px + c);
      for (std::size_t k = 0; k < count; ++k) {
        sum[k] += share[0] * values[0][k] + share[1] * values[1][k] + share[2] * values[2][k];
      }
    }
  }
}

void ValueDeposit::add_to(StreakWindow& window, int first_plane) const {
  for (std::size_t k = 0; k < count; ++k) {
    for (int r = 0; r < window.rows; ++r) {
      double* to = window.row(first_plane + static_cast<int>(k), r);
      const double* from = sums.data() + count * static_cast<std::size_t>(r * window.width_px) + k;
      for (int c = 0; c < window.width_px; ++c) to[c] += from[count * static_cast<std::size_t>(c)];
    }
  }
}

}  // namespace pluvia
