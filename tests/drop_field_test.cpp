#include "raytrace/drop_field.h"

#include <cmath>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

Scene rain_scene(double drops_per_m3) {
  Scene scene;
  scene.rain.drops_per_m3 = drops_per_m3;
  scene.rain.box_min_m = {-10, -5, 0};
  scene.rain.box_max_m = {10, 15, 12};
  scene.rain.seed = 20061117;
  return scene;
}

const TopHeight no_ground = {};

// Pearson's statistic of `bins` equally likely classes.
double chi_square(const std::vector<long>& counts) {
  double total = 0, sum = 0;
  for (long n : counts) total += static_cast<double>(n);
  const double expected = total / static_cast<double>(counts.size());
  for (long n : counts) sum += std::pow(static_cast<double>(n) - expected, 2) / expected;
  return sum;
}

// Wilson and Hilferty's approximation of the chi-square quantile at z standard deviations.
double quantile(int degrees, double z) {
  const double a = 2.0 / (9.0 * degrees);
  return degrees * std::pow(1 - a + z * std::sqrt(a), 3);
}

// z = 4: false alarm 3e-5 a statistic, that is 1e-3 over all that this file computes.
bool looks_uniform(const std::vector<long>& counts) {
  return chi_square(counts) < quantile(static_cast<int>(counts.size()) - 1, 4);
}

std::size_t bin(double value, double low, double high, std::size_t bins) {
  return static_cast<std::size_t>((value - low) / (high - low) * static_cast<double>(bins));
}

TEST(DropField, TheHashIsPcg3dAsPublished) {
  // Jarzynski and Olano's HLSL worked through for (0, 0, 0), where all words start as the increment
  // c: in 64 bits, reduced modulo 2^32 after each product.
  using Wide = unsigned long long;
  const Wide c = 1013904223, m = 1ULL << 32;
  Wide x = (c + c * c % m) % m, y = (c + c * x % m) % m, z = (c + x * y % m) % m;
  x ^= x >> 16, y ^= y >> 16, z ^= z >> 16;
  x = (x + y * z % m) % m, y = (y + z * x % m) % m, z = (z + x * y % m) % m;
  const auto hash = rain_hash(0, 0, 0);
  EXPECT_EQ(hash[0], x);
  EXPECT_EQ(hash[1], y);
  EXPECT_EQ(hash[2], z);
}

TEST(DropField, DropsFillTheBoxEvenlyAtAnyTime) {
  const Scene scene = rain_scene(20);  // 96,000 drops
  for (double time_s : {0.0, 0.7, 1000.0, 86400.0}) {
    std::vector<long> x(64), y(64), z(64), set(10), cell(4 * 4 * 4);
    for (const Drop& drop : drop_field(scene, no_ground, 10, time_s)) {
      const auto& p = drop.centre_m;
      ++x[bin(p.x(), -10, 10, 64)];
      ++y[bin(p.y(), -5, 15, 64)];
      ++z[bin(12 - p.z(), 0, 12, 64)];
      ++set[static_cast<std::size_t>(drop.oscillation)];
      ++cell[bin(p.x(), -10, 10, 4) * 16 + bin(p.y(), -5, 15, 4) * 4 + bin(12 - p.z(), 0, 12, 4)];
    }
    for (const auto* counts : {&x, &y, &z, &set, &cell})
      EXPECT_TRUE(looks_uniform(*counts)) << chi_square(*counts) << " at " << time_s << " s";
  }
}

TEST(DropField, NeighbouringDropsRoundsAndSeedsAreIndependent) {
  // Joint counts of the first coordinate's eighth for (k, k + 1), for (round, round + 1) of one
  // drop, and for two seeds that differ in one bit of the high word.
  Scene scene = rain_scene(20);
  const auto first = drop_field(scene, no_ground, 1, 0);
  const double fall_s = 12 / scene.rain.fall_speed_m_s;
  const auto next = drop_field(scene, no_ground, 1, fall_s * (1 + 1e-9));
  scene.rain.seed ^= 1ULL << 40;
  const auto other = drop_field(scene, no_ground, 1, 0);
  std::vector<long> drops(64), rounds(64), seeds(64);
  for (std::size_t k = 0; k + 1 < first.size(); ++k) {
    const auto eighth = [](const Drop& d) { return bin(d.centre_m.x(), -10, 10, 8); };
    ++drops[eighth(first[k]) * 8 + eighth(first[k + 1])];
    ++rounds[eighth(first[k]) * 8 + eighth(next[k])];
    ++seeds[eighth(first[k]) * 8 + eighth(other[k])];
  }
  for (const auto* counts : {&drops, &rounds, &seeds})
    EXPECT_TRUE(looks_uniform(*counts)) << chi_square(*counts);
}

TEST(DropField, ThereAreAsManyDropsAsDensityTimesVolume) {
  for (double density : {0.0, 1e-4, 0.5, 20.0}) {
    const auto drops = drop_field(rain_scene(density), no_ground, 10, 3);
    EXPECT_EQ(drops.size(), static_cast<std::size_t>(std::lround(density * 20 * 20 * 12)));
    for (std::size_t k = 0; k < drops.size(); ++k) ASSERT_EQ(drops[k].id, k);
  }
}

TEST(DropField, ADropFallsStraightUntilItLeavesTheBoxAndReentersElsewhere) {
  const Scene scene = rain_scene(0.2);
  const double dt = 1.0 / 60, step_m = dt * scene.rain.fall_speed_m_s;
  auto before = drop_field(scene, no_ground, 10, 5);
  long wraps = 0;
  for (int frame = 1; frame <= 120; ++frame) {
    const auto after = drop_field(scene, no_ground, 10, 5 + frame * dt);
    for (std::size_t k = 0; k < after.size(); ++k) {
      const Eigen::Vector3d &a = before[k].centre_m, &b = after[k].centre_m;
      // A phase is 3 nm; the difference of two, 6 nm.
      if (a.z() - step_m > 1e-8) {
        ASSERT_NEAR(b.z(), a.z() - step_m, 1e-8) << "drop " << k;
        ASSERT_TRUE(a.x() == b.x() && a.y() == b.y()) << "drop " << k;
        ASSERT_EQ(before[k].oscillation, after[k].oscillation);
      } else if (a.z() - step_m < -1e-8) {
        ASSERT_NEAR(b.z(), a.z() - step_m + 12, 1e-8) << "drop " << k;
        ASSERT_NE(a.x(), b.x()) << "drop " << k;
        ASSERT_NE(a.y(), b.y()) << "drop " << k;
        ++wraps;
      }
    }
    before = after;
  }
  // 960 drops, 2 s, 1.41 s a fall: every drop at least once.
  EXPECT_GE(wraps, 960);
}

TEST(DropField, ADropDoesNotDependOnWhichTimesWereAskedForBefore) {
  const Scene scene = rain_scene(1);
  const auto first = drop_field(scene, no_ground, 10, 12.5);
  for (double time_s : {80000.0, 0.0, 12.4999}) drop_field(scene, no_ground, 10, time_s);
  const auto again = drop_field(scene, no_ground, 10, 12.5);
  for (std::size_t k = 0; k < first.size(); ++k) {
    ASSERT_EQ(first[k].centre_m, again[k].centre_m);
    ASSERT_EQ(first[k].oscillation, again[k].oscillation);
  }
}

TEST(DropField, TheClosedFormIsExactToAMicrometreAfterADay) {
  // Independent arithmetic: time in whole nanoseconds, 8.49 m/s = 8490 um/s and 12 m = 12e6 um give
  // the fallen height in 1e-9 um without rounding in 128 bits.
  const Scene scene = rain_scene(0.05);
  const auto start = drop_field(scene, no_ground, 1, 0);
  for (long long ns : {86400000000000LL, 86399983333333LL, 100000000000007LL}) {
    const auto drops = drop_field(scene, no_ground, 1, static_cast<double>(ns) * 1e-9);
    const __int128 height = static_cast<__int128>(12000000) * 1000000000;
    const __int128 fallen = static_cast<__int128>(ns) * 8490000 % height;
    for (std::size_t k = 0; k < drops.size(); ++k) {
      const auto depth = static_cast<__int128>(std::llround((12 - start[k].centre_m.z()) * 1e15));
      const double expected = 12 - static_cast<double>((depth + fallen) % height) * 1e-15;
      // 1e-6 m, except that a drop within that of the wrap may stand on either side of it.
      const double off = std::abs(drops[k].centre_m.z() - expected);
      EXPECT_LT(std::min(off, std::abs(12 - off)), 1e-6) << "drop " << k << " at " << ns << " ns";
    }
  }
}

TEST(DropField, RoundsAreCountedInWholeFallsOfTheBox) {
  Rain rain;
  rain.fall_speed_m_s = 8;
  rain.box_min_m.z() = -4;
  rain.box_max_m.z() = 12;  // a fall lasts 2 s exactly
  for (unsigned n : {0u, 1u, 43200u, 5000000u}) {
    const FallState at = fall_state(rain, 2.0 * n);
    EXPECT_EQ(at.round, n);
    EXPECT_EQ(at.phase, 0u);
    const FallState half = fall_state(rain, 2.0 * n - (n ? 1.0 : -1.0));
    EXPECT_EQ(half.round, n ? n - 1 : 0);
    EXPECT_EQ(half.phase, 1u << 31);
  }
}

TEST(DropField, ABoxOfAMillimetreKeepsItsDrops) {
  Scene scene = rain_scene(1e12);
  scene.rain.box_min_m = {1, 2, 3};
  scene.rain.box_max_m = {1.001, 2.001, 3.001};
  for (double time_s : {0.0, 1.0, 86400.0}) {
    const auto drops = drop_field(scene, no_ground, 3, time_s);
    ASSERT_EQ(drops.size(), 1000u);
    for (const Drop& drop : drops) {
      ASSERT_TRUE((drop.centre_m.array() >= scene.rain.box_min_m.array()).all());
      ASSERT_TRUE((drop.centre_m.array() <= scene.rain.box_max_m.array()).all());
      ASSERT_TRUE(drop.oscillation >= 0 && drop.oscillation < 3);
    }
  }
}

TEST(DropField, ADropHitsWhatLiesBelowIt) {
  Scene scene = rain_scene(1);
  scene.mesh.positions_m = {{-50, -50, 4}, {0, -50, 4}, {0, 50, 4}, {-50, 50, 4}};  // x < 0: a roof
  scene.mesh.indices = {0, 1, 2, 0, 2, 3};
  const TopHeight top = top_height(scene.mesh, scene.rain, 0.1);
  long under_roof = 0;
  for (const Drop& drop : drop_field(scene, top, 10, 1)) {
    const double x = drop.centre_m.x();
    if (x > 0.1) {
      EXPECT_GT(drop.hit_time_s, 1e26);
    } else if (x < -0.1) {
      EXPECT_NEAR(drop.hit_time_s, (drop.centre_m.z() - 4) / 8.49, 1e-9);
      under_roof += drop.hit_time_s <= 0;
    }
  }
  // A third of the drops on that side (4 of 12 m): 796 +- 23.
  EXPECT_NEAR(static_cast<double>(under_roof), 796, 5 * 23);
}

TEST(DropField, ATimeBeforeTheStartOrWithoutNumberIsRefused) {
  for (double time_s : {-1.0, 1.1e7, std::nan(""), HUGE_VAL})
    EXPECT_NE(message_of([&] { fall_state({}, time_s); }).find("expected 0 .. 1"),
              std::string::npos)
        << time_s;
}

}  // namespace
}  // namespace pluvia
