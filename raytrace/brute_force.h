// The judge of the exit field: camera rays through the picture at random times, followed through
// the drop and counted where they leave within a light's cone. By itself it shares nothing with the
// field but the intersection (and that through Embree): its own path follower, and polarisation as
// Stokes vectors with Mueller matrices instead of fields. The same rays may be followed by the
// field's own tracer, several at a time: several times as many for the same time
// (docs/generator.md), and what counting rays is fairly compared with.
//
// Each replicate is a randomly shifted low-discrepancy point set in (x, y, t); the spread of the
// replicates gives an unbiased variance of their mean, per pixel and per light's flux.
#pragma once

#include <cstdint>
#include <functional>

#include "raytrace/streak_tracer.h"

namespace pluvia {

enum class RayFollower {
  independent,   // Embree and Mueller matrices, one ray after the other
  wide,          // raytrace/wide_paths.h, with the field options' instruction set
  mesh,          // as independent, but of a triangle mesh of each instant, with smooth normals
  polished_mesh  // the same mesh, each of its hits moved onto the analytic surface
};

struct BruteOptions {
  int replicates = 16;          // >= 2
  int instants = 256;           // stratified times per replicate
  int rays_per_instant = 2000;  // over the drop's bounding square
  std::uint64_t seed = 7;
  RayFollower follower = RayFollower::independent;
  // False: light leaves every interface unpolarised, to tell what that costs (an averaged Fresnel
  // share at each); of the independent follower alone.
  bool polarised = true;
  int mesh_levels = 5;  // of a mesh: 8 * 4^levels triangles, 0 .. 9
};

struct ReplicateMean {
  double mean = 0;
  double standard_error = 0;
};

struct BruteStreak {
  std::vector<StreakImage> light = {};  // as TracedStreak's, mean and variance of the mean
  StreakImage env = {};
  StreakImage coverage = {};
  std::vector<ReplicateMean> flux = {};  // per light: sum over all pixels
  ReplicateMean env_flux = {}, coverage_flux = {};
  double rays = 0;  // that met the drop
};

// Throws std::invalid_argument for a cone of half angle 0: no ray meets a point; and for wide rays
// that are not to be polarised.
// Of the request's field options only those of the paths and the instruction set are used. Same
// bytes for any thread count. `progress` gets the share done, 0 .. 1, from one thread at a time.
BruteStreak brute_force_streak(const StreakRequest& request, const BruteOptions& options,
                               const std::function<void(double)>& progress = {});

}  // namespace pluvia
