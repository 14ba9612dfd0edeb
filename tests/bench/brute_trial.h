// One shard of the generator's judge: the exit field and brute force on the same lights.
//
// Brute force runs in batches of equal size (batch_judge.h), at least `batches` of them, then until
// its error is at most three times that of the field, and the field's is seen through it, wherever
// the two are compared, or its time is up. Its time to the field's error then follows from 1 /
// sqrt(rays); whether that law holds is measured, by `batches` more of a quarter of the rays. Where
// the field's error still drowns in what is left of brute force's noise, two standard errors above
// it stand for it, and the ratio is a lower bound. Compared are pixels, and rows: sums over their
// columns.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "raytrace/brute_force.h"
#include "tests/bench/shard_choice.h"
#include "validate/batch_judge.h"

namespace pluvia {

constexpr double farthest_extrapolation = 3;  // in error

struct TrialOptions {
  std::vector<std::string> lights = {};  // names of the judged ones
  int batches = 8;                       // >= 3
  int instants = 1024;                   // of half a batch, >= 2
  int rays_per_instant = 2000;           // over the drop's bounding square, >= 2
  double brute_cpu_s = 600;              // of all batches, at most (but at least `batches`)
  RayFollower follower = RayFollower::wide;
};

enum Scale : std::size_t { pixels, rows, scales };

// How much longer brute force takes, in CPU time.
struct SpeedRatio {
  double brute_s = 0;        // to the field's error; 0: brute force did not see the light
  double speed = 0;          // brute_s over the field's time
  double extrapolation = 0;  // brute force's error over the field's; below 1: interpolated
  bool bound = false;        // the field's error is only known to be less
};

// The field against brute force in one picture.
struct Figure {
  std::size_t light = 0;  // of the judged ones
  bool all = true;        // both for all lights at once, or both for this one alone
  Scale scale = pixels;
  double field_s = 0;
  BatchVerdict verdict = {};
  double brute_error = 0;  // relative, of all batches together
  SpeedRatio ratio = {};
};

struct LightFlux {
  double field = 0;
  MeanAndError brute = {};
};

struct Trial {
  std::string shard = {};
  std::vector<LightFlux> fluxes = {};  // of the judged lights
  LightFlux total = {};                // of all the preset's lights together
  std::size_t lights = 0;              // how many those are
  double field_s = 0;                  // CPU time for all of them at once
  double brute_s = 0, rays = 0;        // of all batches; rays that met the drop
  std::size_t batches = 0;
  std::vector<Figure> figures = {};  // by light, all before one, pixels before rows
  // Of brute force's error against rays, for each judged light that it saw: -1/2 by the law.
  std::array<std::vector<double>, scales> exponents = {};
};

// Throws CLI::ValidationError for a light that the shard does not have.
Trial judge_shard(const ChosenShard& shard, const TrialOptions& options);

}  // namespace pluvia
