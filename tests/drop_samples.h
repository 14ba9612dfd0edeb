// Drops, directions and rays that several tests draw at random, always from a stated seed.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "oscillation/drop_shape.h"

namespace pluvia {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Uniform on the sphere.
inline Eigen::Vector3d random_direction(Random& random) {
  const double z = uniform(random, -1, 1), phi = uniform(random, 0, 2 * std::numbers::pi);
  const double rho = std::sqrt(1 - z * z);
  return {rho * std::cos(phi), rho * std::sin(phi), z};
}

// The drop at the instant when all its modes stand at their full amplitude.
inline DropInstant frozen_drop(const std::vector<Mode>& modes, double mean_radius_m = 1e-3) {
  DropShape shape;
  shape.mean_radius_m = mean_radius_m;
  shape.modes = modes;
  for (Mode& mode : shape.modes) mode.phase_rad = std::numbers::pi / 2;
  return drop_at(shape, 0);
}

// The two modes of Garg and Nayar at large amplitudes: concave in several places.
inline DropInstant concave_drop(double a20 = 0.3, double a31 = 0.2, double mean_radius_m = 1e-3) {
  return frozen_drop({{.n = 2, .m = 0, .amplitude = a20}, {.n = 3, .m = 1, .amplitude = a31}},
                     mean_radius_m);
}

// The drops on which rays are tried: published modes at strong, concave amplitudes; many waves;
// moved.
inline std::vector<DropInstant> hard_drops() {
  DropShape moved;
  moved.modes = {{2, 0, 0.3, std::numbers::pi / 2}, {3, 1, 0.2, std::numbers::pi / 2}};
  moved.keep_volume = moved.keep_centroid = true;
  return {concave_drop(), concave_drop(-0.3, 0.2),
          frozen_drop({{8, 0, 0.1, 0}, {8, 5, 2e-6, 0}, {2, 0, -0.2, 0}}),
          frozen_drop({{8, 8, 2e-8, 0}, {3, 1, 0.15, 0}}), drop_at(moved, 0)};
}

}  // namespace pluvia
