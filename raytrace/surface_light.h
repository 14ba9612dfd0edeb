// Light of other environments than the uniform one, from the exit-direction field: what every node
// of the surface would send to the camera under each spherical harmonic (the transfer), and under a
// given map, and how that is brought into the pictures along with the environment and the coverage.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "raytrace/environment_map.h"
#include "raytrace/exit_field.h"
#include "raytrace/streak_frame.h"

namespace pluvia {

struct EnvironmentRequest {
  bool uniform = true;       // the picture under a uniform environment
  int transfer_degree = -1;  // harmonics of degrees 0 .. this, <= highest_harmonic_degree; -1: none
  EnvironmentMap map = {};   // no picture where it is empty
};

// Pictures beyond the uniform one: the harmonics by harmonic_index, then the map's channels.
std::size_t transfer_count(const EnvironmentRequest& request);
std::size_t map_count(const EnvironmentRequest& request);
std::size_t value_count(const EnvironmentRequest& request);  // both

// Their values at a node of the field: the sum over its exits of throughput times Y_lm(direction),
// or times the map's radiance. Beyond the outline (facing <= 0) all light is reflected, as in the
// uniform environment's throughput of 1 there.
void node_values(const ExitField& field, std::uint32_t node, const EnvironmentRequest& request,
                 std::span<double> values);

// Rows of values, one for each place.
using ValueRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A cell's node values, and values between them.
struct CellValues {
  int times = 1;
  ValueRows nodes = {};  // row 16 * time + place

  // At a share of the cell's time, on a grid of (steps + 1)^2 places of its space, u fastest: the
  // tricubic polynomial through all nodes. steps >= 1.
  ValueRows grid(double share, std::size_t steps) const;

  // At the 16 places, a share of the way from the time of nodes `before` to the next: in between
  // where both are known, else as at the nearer time. Rows of places that are known at neither are
  // of no meaning.
  ValueRows loose(const ExitField& field, const FieldCell& cell, std::size_t before,
                  double share) const;
};

CellValues cell_values(const ExitField& field, const FieldCell& cell,
                       const EnvironmentRequest& request);

// Sums of many values at once: a triangle's area is spread over pixels once for each corner, not
// for each value.
struct ValueDeposit {
  StreakWindow corners = {};      // scratch: the shares of a triangle's corners; zero in between
  std::size_t count = 0;          // values
  std::vector<double> sums = {};  // row, column, value

  // As streak_frame.h's deposit() for every value, which is linear between the corners a, b, c.
  // polygon: what is left of the triangle after clipping, with the corners' shares in dx, dy, dz.
  void add(const Travel& travel, const ConePolygon& polygon, double weight,
           const std::array<const double*, 3>& values);

  // Adds the sums to the window's planes first_plane ..
  void add_to(StreakWindow& window, int first_plane) const;
};

ValueDeposit make_value_deposit(const StreakWindow& window, std::size_t count);

}  // namespace pluvia
