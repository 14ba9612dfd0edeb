#include "raytrace/wide_paths.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "raytrace/wide_intersect.h"
#include "tests/drop_samples.h"
#include "tests/wide_samples.h"
#include "raytrace/sphere_closed_form.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

class WidePaths : public testing::Test {
 protected:
  void SetUp() override {
    if (isas.empty()) GTEST_SKIP() << "this processor has neither AVX2 nor AVX-512";
  }
  const std::vector<Isa> isas = wide_isas();
};

// Points that the camera sees, and some that lie up to a tenth beyond the outline.
std::vector<CameraHit> random_hits(const DropInstant& drop, const Eigen::Vector3d& to_camera,
                                   Random& random, std::size_t count) {
  std::vector<CameraHit> hits;
  while (hits.size() < count) {
    const auto point =
        surface_points_of(drop, {{random_direction(random)}}, to_camera, Isa::scalar).front();
    const double facing = point.normal.dot(to_camera);
    if (facing > 0 ? point.hidden : facing < -0.1) continue;
    hits.push_back({point.position_m, point.normal});
  }
  return hits;
}

using ExitsByPath = std::map<std::uint64_t, PathExit>;

ExitsByPath exits_of(const HitExits& traced, std::size_t hit) {
  ExitsByPath exits;
  for (std::uint32_t k = traced.first_exit[hit]; k < traced.first_exit[hit + 1]; ++k) {
    EXPECT_TRUE(exits.emplace(traced.exits[k].signature, traced.exits[k]).second);
  }
  return exits;
}

// Largest difference between two sets of exits; infinite where they have different paths, or one
// that carries light in one of them only.
double difference(const ExitsByPath& a, const ExitsByPath& b) {
  constexpr double unlike = std::numeric_limits<double>::infinity();
  if (a.size() != b.size()) return unlike;
  double largest = 0;
  for (const auto& [path, exit] : a) {
    const auto other = b.find(path);
    if (other == b.end() || other->second.order != exit.order) return unlike;
    const double throughput = other->second.throughput;
    if ((throughput == 0) != (exit.throughput == 0)) return unlike;
    if (other->second.refracted != exit.refracted) return unlike;
    largest = std::max({largest, (other->second.direction - exit.direction).norm(),
                        std::abs(throughput - exit.throughput),
                        (other->second.incident - exit.incident).norm(),
                        (other->second.normal - exit.normal).norm(),
                        std::abs(other->second.power_s - exit.power_s),
                        std::abs(other->second.power_p - exit.power_p)});
  }
  return largest;
}

// How far the scalar tracer's own exits move when the hit moves by 1e-12 r0 and its normal by
// 1e-12: in three directions, the largest.
double sensitivity(const DropInstant& drop, const CameraHit& hit, const Eigen::Vector3d& to_camera,
                   const PathOptions& options, Random& random) {
  const auto trace = [&](const CameraHit& from) {
    return exits_of(trace_exits_of(drop, {{from}}, to_camera, options, Isa::scalar), 0);
  };
  const ExitsByPath exits = trace(hit);
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    CameraHit moved = hit;
    moved.position_m += 1e-12 * drop.surface.scale * random_direction(random);
    moved.normal = (hit.normal + 1e-12 * random_direction(random)).normalized();
    largest = std::max(largest, difference(exits, trace(moved)));
  }
  return largest;
}

struct Sample {
  DropInstant drop = {};
  PathOptions options = {};
};

// The hard drops with many orders, few orders, weak beams given up and glass; equilibrium shapes.
std::vector<Sample> samples() {
  std::vector<Sample> samples;
  const PathOptions kinds[] = {
      {}, {.max_order = 0}, {.max_order = 8, .min_power = 1e-5}, {.refractive_index = 1.5}};
  std::vector<DropInstant> drops = hard_drops();
  drops.push_back(frozen_drop({}));
  drops.push_back(concave_drop(0.15, 0.1, 0.05e-3));
  DropShape falling;
  falling.equilibrium_cos = {-0.0131, -0.012, -0.0376, -0.0096, -0.0004, 0.0015,
                             0.0005,  0,      -0.0002, 0,       0.0001};
  falling.modes = {{2, 0, 0.1, 1}, {3, 1, 0.05, 2}, {4, 2, 0.003, 0}};
  falling.phi_drop_rad = 0.7;
  drops.push_back(drop_at(falling, 1e-3));
  for (std::size_t i = 0; i < drops.size(); ++i) {
    samples.push_back({drops[i], {}});
    samples.push_back({drops[i], kinds[i % std::size(kinds)]});
  }
  return samples;
}

TEST_F(WidePaths, DifferFromTheScalarTracerByRoundingOnly) {
  // The roots of both stop at |G| <= 4e-15, each meeting adds some roundings of 1e-16, and the rest
  // of the path carries these errors as it carries a move of the hit: of 1e-12, 100 times as much,
  // so the scalar tracer's own sensitivity bounds them. Where that is infinite the hit stands on a
  // break, to 1e-12 r0.
  Random random(1);
  std::size_t hits_seen = 0, on_breaks = 0, up_to_order_3 = 0, above_1e12 = 0;
  for (const Sample& sample : samples()) {
    const Eigen::Vector3d to_camera = random_direction(random);
    const auto hits = random_hits(sample.drop, to_camera, random, 301);
    const auto scalar = trace_exits_of(sample.drop, hits, to_camera, sample.options, Isa::scalar);
    for (const Isa isa : isas) {
      const auto wide = trace_exits_of(sample.drop, hits, to_camera, sample.options, isa);
      ASSERT_EQ(wide.first_exit.size(), hits.size() + 1);
      for (std::size_t i = 0; i < hits.size(); ++i, ++hits_seen) {
        const double found = difference(exits_of(wide, i), exits_of(scalar, i));
        if (sample.options.max_order <= 3) {
          ++up_to_order_3;
          above_1e12 += found > 1e-12 ? 1 : 0;
        }
        if (found <= 1e-13) continue;
        const double moved = sensitivity(sample.drop, hits[i], to_camera, sample.options, random);
        on_breaks += std::isinf(moved) ? 1 : 0;
        ASSERT_LE(found, moved) << isa_name(isa) << ", hit " << i;
      }
    }
  }
  // What the header states.
  EXPECT_LT(static_cast<double>(on_breaks), 1e-3 * static_cast<double>(hits_seen));
  EXPECT_LT(static_cast<double>(above_1e12), 3e-3 * static_cast<double>(up_to_order_3));
}

TEST_F(WidePaths, AHitGetsTheSameBytesInAnyBatchAndOnAnyWideSet) {
  Random random(2);
  const DropInstant drop = concave_drop();
  const Eigen::Vector3d to_camera = random_direction(random);
  const PathOptions options = {.max_order = 5};
  const auto hits = random_hits(drop, to_camera, random, 401);
  const auto whole = trace_exits_of(drop, hits, to_camera, options, isas.front());
  for (const Isa isa : isas) {
    for (std::size_t first = 0; first < hits.size();) {
      const std::size_t count = std::min<std::size_t>(hits.size() - first, random() % 40);
      const auto batch =
          trace_exits_of(drop, std::span(hits).subspan(first, count), to_camera, options, isa);
      ASSERT_EQ(batch.first_exit.size(), count + 1);
      const std::uint32_t offset = whole.first_exit[first];
      for (std::size_t i = 0; i <= count; ++i) {
        ASSERT_EQ(batch.first_exit[i] + offset, whole.first_exit[first + i]);
      }
      for (std::size_t k = 0; k < batch.exits.size(); ++k) {
        const PathExit &a = batch.exits[k], &b = whole.exits[offset + k];
        ASSERT_EQ(a.signature, b.signature);
        ASSERT_EQ(a.order, b.order);
        ASSERT_TRUE(same_bits(a.direction, b.direction)) << isa_name(isa) << ", exit " << k;
        ASSERT_TRUE(same_bits(a.throughput, b.throughput)) << isa_name(isa) << ", exit " << k;
      }
      first += count;
    }
  }
}

TEST_F(WidePaths, TheRemainderIsTheSumOverTheHitsInTheirOrder) {
  Random random(3);
  const DropInstant drop = concave_drop(-0.3, 0.2);
  const Eigen::Vector3d to_camera = {0.6, 0, 0.8};
  const PathOptions options = {.min_power = 1e-3};
  const auto hits = random_hits(drop, to_camera, random, 300);
  for (const Isa isa : isas) {
    PathRemainder sum;
    for (const CameraHit& hit : hits) {
      const auto one = trace_exits_of(drop, {{hit}}, to_camera, options, isa);
      sum.beyond_order += one.remainder.beyond_order;
      sum.given_up += one.remainder.given_up;
      sum.lost += one.remainder.lost;
    }
    const auto all = trace_exits_of(drop, hits, to_camera, options, isa);
    EXPECT_GT(sum.given_up, 0);
    EXPECT_TRUE(same_bits(all.remainder.beyond_order, sum.beyond_order)) << isa_name(isa);
    EXPECT_TRUE(same_bits(all.remainder.given_up, sum.given_up)) << isa_name(isa);
    EXPECT_TRUE(same_bits(all.remainder.lost, sum.lost)) << isa_name(isa);
  }
}

TEST_F(WidePaths, NoPowerIsLostOnConcaveDrops) {
  // Every interface keeps power to 1e-15 and some hundred are met: 1e-12 a hit.
  Random random(4);
  for (const DropInstant& drop : hard_drops()) {
    for (const int max_order : {0, 1, 3, 6}) {
      const PathOptions options = {.max_order = max_order, .min_power = 1e-5};
      const Eigen::Vector3d to_camera = random_direction(random);
      for (const CameraHit& hit : random_hits(drop, to_camera, random, 50)) {
        for (const Isa isa : isas) {
          const auto traced = trace_exits_of(drop, {{hit}}, to_camera, options, isa);
          const PathRemainder& left = traced.remainder;
          double sum = left.beyond_order + left.given_up + left.lost;
          if (hit.normal.dot(to_camera) <= 0) {
            ASSERT_EQ(sum, 0) << "beyond the outline";
            continue;
          }
          for (const PathExit& exit : traced.exits) {
            sum += exit.throughput;
            ASSERT_GE(exit.throughput, 0);
            ASSERT_LE(exit.order, max_order);
            ASSERT_NEAR(exit.direction.norm(), 1, 1e-14);
          }
          ASSERT_NEAR(sum, 1, 1e-12);
        }
      }
    }
  }
}

TEST_F(WidePaths, ASpheresExitsHaveDescartesAnglesAndFresnelsShares) {
  // Order p >= 1 turns the ray by 2 (i - t) + (p - 1) (pi - 2 t), order 0 by pi - 2 i. The angles
  // of incidence are off by 1e-16 / cos i, which stays below 1e-14 up to impact 0.999.
  const DropInstant sphere = frozen_drop({});
  std::vector<CameraHit> hits;
  std::vector<double> impacts;
  for (double impact = 0; impact < 0.9995; impact += 0.037) {
    const Eigen::Vector3d u = {std::sqrt(1 - impact * impact), impact, 0};
    hits.push_back({1e-3 * u, u});
    impacts.push_back(impact);
  }
  for (const Isa isa : isas) {
    const auto traced = trace_exits_of(sphere, hits, {1, 0, 0}, {.max_order = 4}, isa);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const double in = std::asin(impacts[i]), refracted = std::asin(impacts[i] / 1.333);
      ASSERT_EQ(traced.first_exit[i + 1] - traced.first_exit[i], 5u);
      for (const auto& [path, exit] : exits_of(traced, i)) {
        const int p = exit.order;
        const double turn =
            p == 0 ? pi - 2 * in : 2 * (in - refracted) + (p - 1) * (pi - 2 * refracted);
        EXPECT_NEAR(exit.direction.x(), -std::cos(turn), 1e-13) << impacts[i] << ", order " << p;
        EXPECT_NEAR(std::abs(exit.direction.y()), std::abs(std::sin(turn)), 1e-13);
        EXPECT_NEAR(exit.throughput, sphere_throughput(1.333, p, impacts[i]), 1e-13);
      }
    }
  }
}

TEST_F(WidePaths, AnIndexOfOneLetsTheCameraLookStraightThrough) {
  Random random(5);
  const DropInstant drop = concave_drop(0.2, 0.05);
  const Eigen::Vector3d to_camera = random_direction(random);
  auto hits = random_hits(drop, to_camera, random, 200);
  std::erase_if(hits, [&](const CameraHit& hit) { return hit.normal.dot(to_camera) <= 0; });
  for (const Isa isa : isas) {
    const auto traced = trace_exits_of(drop, hits, to_camera, {.refractive_index = 1}, isa);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      double straight = 0;
      for (const auto& [path, exit] : exits_of(traced, i)) {
        if ((exit.direction + to_camera).norm() < 1e-12) straight += exit.throughput;
      }
      EXPECT_NEAR(straight, 1, 1e-12) << i;
    }
  }
}

TEST_F(WidePaths, AnIndexOfOneTransmitsBeyondTheOutlineAsTheScalarTracerDoes) {
  // There reflection and refraction would be ratios of zeros, were they not told apart. Every hit
  // keeps one reflected exit, without light.
  Random random(6);
  const DropInstant drop = concave_drop(0.2, 0.05);
  const Eigen::Vector3d to_camera = random_direction(random);
  auto hits = random_hits(drop, to_camera, random, 400);
  std::erase_if(hits, [&](const CameraHit& hit) { return hit.normal.dot(to_camera) > 0; });
  ASSERT_GT(hits.size(), 10u);
  const PathOptions options = {.refractive_index = 1};
  const auto scalar = trace_exits_of(drop, hits, to_camera, options, Isa::scalar);
  for (const Isa isa : isas) {
    const auto wide = trace_exits_of(drop, hits, to_camera, options, isa);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const ExitsByPath exits = exits_of(wide, i);
      EXPECT_LE(difference(exits, exits_of(scalar, i)), 1e-12) << isa_name(isa) << ", hit " << i;
      ASSERT_FALSE(exits.empty());
      for (const auto& [path, exit] : exits) {
        ASSERT_TRUE(exit.direction.allFinite() && std::isfinite(exit.throughput));
        ASSERT_TRUE(std::isfinite(exit.power_s) && std::isfinite(exit.power_p));
        if (exit.order == 0) {
          EXPECT_EQ(exit.throughput, 0);
        }
      }
    }
  }
}

TEST_F(WidePaths, NoHitsGiveNoExits) {
  for (const Isa isa : isas) {
    const auto traced = trace_exits_of(concave_drop(), {}, {1, 0, 0}, {}, isa);
    EXPECT_EQ(traced.first_exit, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(traced.exits.empty());
  }
}

}  // namespace
}  // namespace pluvia
