// Made-up outlines of known drops.
#pragma once

#include "oscillation/outline.h"
#include "oscillation/outline_table.h"
#include "tests/drop_samples.h"

namespace pluvia {

struct OutlineSampling {
  int times = 12, angles = 24;
  double duration_s = 1.0 / 60;
  double view_elevation_rad = 0.5, view_azimuth_rad = 0;
  double noise_m = 0;        // standard deviation of the radii
  double outlier_share = 0;  // of the points: anywhere in 0.5 .. 2.5 mm
  std::uint64_t seed = 1;
};

// Standard normal, by Box and Muller: the standard library's differs between libraries.
inline double normal(Random& random) {
  const double u = uniform(random, 0, 1), v = uniform(random, 0, 1);
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * std::numbers::pi * v);
}

inline Outlines made_outlines(const DropShape& drop, const OutlineSampling& sampling) {
  Random random(sampling.seed);
  Outlines outlines{.source = "made up", .points = {}};
  for (int i = 0; i < sampling.times; ++i) {
    const double t = sampling.duration_s * i / std::max(1, sampling.times - 1);
    const DropInstant instant = drop_at(drop, t);
    for (int k = 0; k < sampling.angles; ++k) {
      const double theta = 2 * std::numbers::pi * k / sampling.angles;
      const OutlineRay ray =
          outline_ray(sampling.view_elevation_rad, sampling.view_azimuth_rad, theta);
      double radius = outline_radius_m(instant.surface, ray);
      if (sampling.noise_m > 0) radius += sampling.noise_m * normal(random);
      if (uniform(random, 0, 1) < sampling.outlier_share) radius = uniform(random, 0.5e-3, 2.5e-3);
      outlines.points.push_back(
          {t, theta, radius, 0, sampling.view_elevation_rad, sampling.view_azimuth_rad});
    }
  }
  return outlines;
}

// The second oscillation set of 2006 with phases of its own.
inline DropShape oscillating_drop() {
  DropShape drop;
  drop.mean_radius_m = 1.6e-3;
  drop.modes = {{.n = 2, .m = 0, .amplitude = 0.11, .phase_rad = 0.4},
                {.n = 3, .m = 1, .amplitude = 0.08, .phase_rad = -1.1}};
  drop.phi_drop_rad = 0.7;
  return drop;
}

}  // namespace pluvia
