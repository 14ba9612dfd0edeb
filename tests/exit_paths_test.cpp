#include "raytrace/exit_paths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/drop_intersect.h"
#include "tests/drop_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

struct Traced {
  std::vector<PathExit> exits = {};
  PathRemainder remainder = {};
  Eigen::Vector3d to_camera = {1, 0, 0};
};

double light_of(const std::vector<PathExit>& exits) {
  double sum = 0;
  for (const PathExit& exit : exits) sum += exit.throughput;
  return sum;
}

// The exits at the point that a camera sees along a ray; none when the ray passes the drop.
std::optional<Traced> trace_ray(const DropInstant& drop, const Eigen::Vector3d& to_camera,
                                const Eigen::Vector3d& through, const PathOptions& options) {
  const auto hit = intersect_drop(drop, through + 5e-3 * to_camera, -to_camera, RaySide::outside);
  if (!hit) return std::nullopt;
  Traced traced;
  traced.to_camera = to_camera;
  traced.remainder =
      trace_exits(drop, hit->position, hit->normal, to_camera, options, traced.exits);
  return traced;
}

Traced trace_sphere(double impact, const PathOptions& options) {
  return *trace_ray(frozen_drop({}), {1, 0, 0}, {0, impact * 1e-3, 0}, options);
}

TEST(ExitPaths, TheMapGoesOnPastTheOutline) {
  // Along the equator through the outline, at equal steps h = 2e-3 of the direction from the
  // centre. Reflection goes on smoothly: its fourth difference is h^4 f'''', below 2e-7 for
  // derivatives up to 1e4. Refracted light leaves a circle as it entered, grazing: its directions
  // have a kink there, but no step (slopes are of order 1: 10 h), and its light fades to zero and
  // counts negative behind.
  const DropInstant drop = frozen_drop({{.n = 2, .amplitude = 0.1}});
  const double step = 2e-3;
  const auto exits_at = [&](double angle) {
    const Eigen::Vector3d u = {std::cos(angle), std::sin(angle), 0};
    std::vector<PathExit> exits;
    trace_exits(drop, surface_radius_m(drop, u) * u, surface_normal(drop, u), {1, 0, 0}, {}, exits);
    std::sort(exits.begin(), exits.end(),
              [](const PathExit& a, const PathExit& b) { return a.signature < b.signature; });
    return exits;
  };
  std::array<std::vector<PathExit>, 5> line;
  for (std::size_t k = 0; k < 5; ++k) {
    line[k] = exits_at(pi / 2 + (static_cast<double>(k) - 3.5) * step);
    ASSERT_EQ(line[k].size(), 4u);
  }
  for (std::size_t e = 0; e < 4; ++e) {
    EXPECT_LT((line[4][e].direction - line[3][e].direction).norm(), 10 * step) << "exit " << e;
    EXPECT_EQ(line[4][e].throughput<0, line[0][e].order> 0);
    if (line[0][e].order > 0) {
      EXPECT_LT(std::abs(line[4][e].throughput), 10 * step);
      continue;
    }
    const auto fourth = [&](auto value) {
      return value(line[0][e]) - 4 * value(line[1][e]) + 6 * value(line[2][e]) -
             4 * value(line[3][e]) + value(line[4][e]);
    };
    EXPECT_LT(std::abs(fourth([](const PathExit& x) { return x.throughput; })), 2e-7);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(fourth([&](const PathExit& x) { return x.direction[axis]; })), 2e-7);
    }
  }
}

TEST(ExitPaths, TheLastInterfaceGivesDirectionAndThroughput) {
  // From the fields along the path and from the powers at its end: 1e-12, roundings of some tens of
  // operations, near grazing exits divided by a cosine. Where light meets the drop again the
  // throughput is 0 and so are the powers.
  Random random(5);
  const DropInstant drop = concave_drop(0.15, 0.1);
  int refracted = 0, total = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d to_camera = random_direction(random), u = random_direction(random);
    const Eigen::Vector3d normal = surface_normal(drop, u);
    if (normal.dot(to_camera) < -0.35) continue;
    std::vector<PathExit> exits;
    trace_exits(drop, surface_radius_m(drop, u) * u, normal, to_camera, {}, exits);
    for (const PathExit& exit : exits) {
      const InterfaceExit end = leave_interface(exit.refracted, exit.incident, exit.normal,
                                                exit.power_s, exit.power_p, 1.333);
      ASSERT_LT((end.direction - exit.direction).norm(), 1e-7) << i;
      ASSERT_NEAR(end.throughput, exit.throughput, 1e-7 * std::max(1.0, exit.throughput)) << i;
      refracted += exit.refracted ? 1 : 0;
      total += end.margin <= 0 ? 1 : 0;
      ASSERT_EQ(exit.order > 0 && end.margin <= 0 && exit.refracted && exit.throughput != 0, false);
    }
  }
  EXPECT_GT(refracted, 1000);
  EXPECT_GT(total, 100);
}

TEST(ExitPaths, NoPowerIsLostOnConcaveDrops) {
  // Every interface keeps power to 1e-15 and some hundred are met: 1e-12.
  Random random(1);
  double most_lost = 0;
  for (const DropInstant& drop :
       {concave_drop(), concave_drop(-0.3, 0.2), concave_drop(0.2, -0.1)}) {
    for (int i = 0; i < 1500; ++i) {
      PathOptions options;
      options.max_order = i % 6;
      options.min_power = i % 2 == 0 ? 1e-7 : 1e-4;
      const Eigen::Vector3d through = uniform(random, 0, 1e-3) * random_direction(random);
      const auto traced = trace_ray(drop, random_direction(random), through, options);
      if (!traced) continue;
      const PathRemainder& left = traced->remainder;
      ASSERT_NEAR(light_of(traced->exits) + left.beyond_order + left.given_up + left.lost, 1, 1e-12)
          << i;
      most_lost = std::max(most_lost, left.lost);
      for (const PathExit& exit : traced->exits) {
        ASSERT_GE(exit.throughput, 0);
        ASSERT_LE(exit.order, options.max_order);
        ASSERT_NEAR(exit.direction.norm(), 1, 1e-14);
      }
    }
  }
  EXPECT_LT(most_lost, 1e-3);
}

TEST(ExitPaths, SignaturesTellAllExitsOfARayApart) {
  Random random(2);
  PathOptions options;
  options.max_order = 6;
  options.min_power = 1e-9;
  for (int i = 0; i < 1000; ++i) {
    const auto traced = trace_ray(concave_drop(), random_direction(random),
                                  0.5e-3 * random_direction(random), options);
    if (!traced) continue;
    // An exit's dark companion (where the path breaks off) continues that path: only one of the two
    // ever has a given signature.
    std::set<std::uint64_t> seen;
    for (const PathExit& exit : traced->exits) {
      EXPECT_TRUE(seen.insert(exit.signature).second) << "ray " << i << ", order " << exit.order;
    }
  }
}

TEST(ExitPaths, ASpheresExitsAreOneAnOrderWithDescartesAnglesAndFresnelsShares) {
  PathOptions options;
  options.max_order = 5;
  options.min_power = 1e-12;
  std::map<int, std::uint64_t> signature_of;
  for (const double b : {0.0, 1e-6, 0.1, 0.3, 0.5, 0.7, 0.86, 0.95, 0.99, 0.9999}) {
    const Traced traced = trace_sphere(b, options);
    ASSERT_EQ(traced.exits.size(), 6u) << b;
    for (const PathExit& exit : traced.exits) {
      // Light from exit.direction goes to the camera at +x.
      const Eigen::Vector3d onward = -exit.direction;
      const double angle = std::atan2(std::hypot(onward.y(), onward.z()), onward.x());
      // Angles near grazing go as the square root of what rounds: 1e-16 / sqrt(2e-4).
      EXPECT_NEAR(angle, sphere_scattering_angle_rad(1.333, exit.order, b), 1e-12) << b;
      EXPECT_NEAR(exit.throughput, sphere_throughput(1.333, exit.order, b), 1e-12) << b;
      EXPECT_NEAR(exit.direction.z(), 0, 1e-13) << b;  // stays in its plane
      const auto [at, fresh] = signature_of.try_emplace(exit.order, exit.signature);
      EXPECT_EQ(at->second, exit.signature) << "the same path has the same name at any impact";
    }
  }
}

TEST(ExitPaths, WhatStaysInsideASphereIsWhatItsOrdersLeave) {
  for (int order = 0; order <= 4; ++order) {
    PathOptions options;
    options.max_order = order;
    options.min_power = 1e-12;
    const Traced traced = trace_sphere(0.6, options);
    double expected = 1;
    for (int p = 0; p <= order; ++p) expected -= sphere_throughput(1.333, p, 0.6);
    EXPECT_NEAR(traced.remainder.beyond_order, expected, 1e-13) << order;
    EXPECT_EQ(traced.remainder.given_up, 0) << order;
    EXPECT_EQ(traced.exits.size(), static_cast<std::size_t>(order) + 1);
  }
}

TEST(ExitPaths, WeakBeamsAreGivenUpAndCounted) {
  PathOptions options;
  options.max_order = 20;
  options.min_power = 1e-3;
  const Traced traced = trace_sphere(0.3, options);
  EXPECT_GT(traced.remainder.given_up, 0);
  EXPECT_LT(traced.remainder.given_up, 1e-3);
  EXPECT_EQ(traced.remainder.beyond_order, 0);
}

TEST(ExitPaths, AnIndexOfOneLetsTheCameraLookStraightThrough) {
  Random random(3);
  PathOptions options;
  options.refractive_index = 1;
  const DropInstant drop = concave_drop(0.2, 0.05);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d to_camera = random_direction(random);
    const auto traced = trace_ray(drop, to_camera, 0.3e-3 * random_direction(random), options);
    ASSERT_TRUE(traced);
    double straight = 0;
    for (const PathExit& exit : traced->exits) {
      if ((exit.direction + to_camera).norm() < 1e-12) straight += exit.throughput;
    }
    EXPECT_NEAR(straight, 1, 1e-12) << i;
  }
}

using ExitsByPath = std::map<std::uint64_t, PathExit>;

ExitsByPath exits_at(const DropInstant& drop, double y, double z) {
  ExitsByPath exits;
  const auto traced = trace_ray(drop, {1, 0, 0}, {0, y, z}, {});
  if (!traced) return exits;
  for (const PathExit& exit : traced->exits) exits[exit.signature] = exit;
  return exits;
}

// Between the heights a (where the path carries light as `bright_at_a` says) and b (where it does
// not agree), the step of direction where it turns dark; nullopt when the path ends in between.
std::optional<double> step_where_dark(const DropInstant& drop, std::uint64_t path, double y,
                                      double a, double b, bool bright_at_a) {
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (a + b);
    const auto exits = exits_at(drop, y, middle);
    const auto found = exits.find(path);
    if (found == exits.end()) return std::nullopt;
    ((found->second.throughput > 0) == bright_at_a ? a : b) = middle;
  }
  return (exits_at(drop, y, a).at(path).direction - exits_at(drop, y, b).at(path).direction).norm();
}

TEST(ExitPaths, WhereAPathTurnsDarkItsDirectionGoesOnWithoutAStep) {
  // Bisected to 1e-17 m, 1e-14 r0: at total reflection the direction goes as the square root of
  // that, 1e-7 times the lever of the refractions before; where the drop is met again, linearly.
  const DropInstant drop = concave_drop(0.3, 0.1);
  int joints = 0;
  for (const double y : {0.0, 0.1e-3, 0.2e-3, 0.3e-3, 0.4e-3}) {
    ExitsByPath before;
    for (double z = -1e-3; z < 1e-3; z += 1e-5) {
      const ExitsByPath here = exits_at(drop, y, z);
      for (const auto& [path, exit] : here) {
        const auto other = before.find(path);
        const bool bright = exit.throughput > 0;
        if (other == before.end() || bright == (other->second.throughput > 0)) continue;
        const auto step = step_where_dark(drop, path, y, z, z - 1e-5, bright);
        if (!step) continue;
        EXPECT_LT(*step, 1e-5) << "y " << y << ", z " << z;
        ++joints;
      }
      before = here;
    }
  }
  EXPECT_GE(joints, 5);
}

}  // namespace
}  // namespace pluvia
