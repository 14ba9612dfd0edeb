#include "raytrace/drop_field.h"

#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

// 20 x 20 x 12 m of rain around the camera.
Scene rain_scene(double drops_per_m3, const Eigen::Vector3d& velocity_m_s = {0, 0, -8.49}) {
  Scene scene;
  scene.camera.position_m = {0.3, 5.1, 6};
  scene.camera.target_m = {0.3, 6, 6};
  scene.rain.sizes = {{.drops_per_m3 = drops_per_m3, .velocity_m_s = velocity_m_s}};
  scene.rain.box_min_m = {-10, -5, 0};
  scene.rain.box_max_m = {10, 15, 12};
  scene.rain.culling_radius_m = 40;
  scene.rain.local_height_m = 12;
  scene.rain.seed = 20061117;
  return scene;
}

// The same without bounds: what is drawn is the prism around the camera.
Scene endless_scene(const std::vector<RainSize>& sizes) {
  Scene scene;
  scene.rain.sizes = sizes;
  scene.rain.culling_radius_m = 4;
  scene.rain.local_height_m = 5;
  scene.rain.seed = 5;
  return scene;
}

std::vector<Drop> field_of(const Scene& scene, double time_s, int sets = 10) {
  return drop_field(scene, make_rain_space(scene), sets, time_s);
}

std::map<DropName, Drop> by_name(const std::vector<Drop>& drops) {
  std::map<DropName, Drop> named;
  for (const Drop& drop : drops) EXPECT_TRUE(named.emplace(drop.name, drop).second);
  return named;
}

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
    for (const Drop& drop : field_of(scene, time_s)) {
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

TEST(DropField, NeighbouringDropsRoundsCellsAndSeedsAreIndependent) {
  // Joint counts of the eighth of the cell in which a drop stands: for drops k and k + 1, for the
  // same drop in two rounds, in two cells, and for two seeds that differ in one bit of the high
  // word.
  Scene scene = rain_scene(20);
  const double cell_m = make_rain_space(scene).sizes[0].cell_m;
  const auto first = by_name(field_of(scene, 0, 1));
  const auto next = by_name(field_of(scene, 12 / 8.49 * (1 + 1e-9), 1));
  scene.rain.seed ^= 1ULL << 40;
  const auto other = by_name(field_of(scene, 0, 1));
  const auto eighth = [&](const Drop& d) {
    const double at = d.centre_m.x() / cell_m;
    return bin(at - std::floor(at), 0, 1, 8);
  };
  std::vector<long> drops(64), rounds(64), cells(64), seeds(64);
  const auto count = [&](const auto& list, DropName name, const Drop& drop, std::vector<long>& to) {
    const auto found = list.find(name);
    if (found != list.end()) ++to[eighth(drop) * 8 + eighth(found->second)];
  };
  for (const auto& [name, drop] : first) {
    DropName changed = name;
    ++changed.number;
    count(first, changed, drop, drops);
    changed = name;
    ++changed.cell_x;
    count(first, changed, drop, cells);
    changed = name;
    ++changed.round;
    count(next, changed, drop, rounds);
    count(other, name, drop, seeds);
  }
  for (const auto* counts : {&drops, &rounds, &cells, &seeds}) {
    EXPECT_TRUE(looks_uniform(*counts)) << chi_square(*counts);
    EXPECT_GT(std::accumulate(counts->begin(), counts->end(), 0L), 10000);
  }
}

TEST(DropField, ThereAreAsManyDropsAsDensityTimesVolumeGiveOrTakePoisson) {
  // 4 standard deviations: false alarm 6e-5 each, 3e-4 for all with the tail of few drops.
  for (double density : {1e-3, 0.5, 20.0}) {
    const auto drops = field_of(rain_scene(density), 3);
    const double expected = density * 20 * 20 * 12;
    EXPECT_NEAR(static_cast<double>(drops.size()), expected, 4 * std::sqrt(expected) + 1);
    for (std::size_t k = 0; k < drops.size(); ++k) ASSERT_EQ(drops[k].id, k);
  }
  EXPECT_TRUE(field_of(Scene{}, 3).empty());
}

TEST(DropField, CellsHoldPoissonNumbers) {
  const RainSpace space = make_rain_space(endless_scene({{.drops_per_m3 = 30}}));
  const RainSizeSpace& size = space.sizes[0];
  const double mean = 30 * space.local_height_m * size.cell_m * size.cell_m;
  double sum = 0, square = 0;
  constexpr int side = 200;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double n = rain_cell(size, x - side / 2, y - side / 2).count;
      sum += n;
      square += n * n;
    }
  }
  const double cells = side * side, found = sum / cells;
  // 4 standard deviations: false alarm 1.3e-4 for both.
  EXPECT_NEAR(found, mean, 4 * std::sqrt(mean / cells));
  // The variance of a variance of Poisson's law: (2 mean^2 + mean) / n.
  EXPECT_NEAR(square / cells - found * found, mean,
              4 * std::sqrt((2 * mean * mean + mean) / cells));
}

// Every drop that two lists both hold is where it was, carried along by its fall; and they hold
// most drops in common.
void expect_same_drops(const std::vector<Drop>& before, const std::vector<Drop>& after,
                       double elapsed_s, double least_share, double bound_m) {
  const auto named = by_name(before);
  std::size_t common = 0;
  double worst_m = 0;
  for (const Drop& drop : after) {
    const auto found = named.find(drop.name);
    if (found == named.end()) continue;
    ++common;
    const Eigen::Vector3d expected = found->second.centre_m + elapsed_s * drop.velocity_m_s;
    worst_m = std::max(worst_m, (drop.centre_m - expected).norm());
    EXPECT_EQ(drop.oscillation, found->second.oscillation);
  }
  EXPECT_LT(worst_m, bound_m);
  EXPECT_GT(static_cast<double>(common), least_share * static_cast<double>(after.size()));
}

const std::vector<RainSize> straight_and_slanted = {
    {.drops_per_m3 = 20},
    {.r0_m = 0.5e-3, .drops_per_m3 = 60, .velocity_m_s = {6, -2, -4}},
    {.r0_m = 2e-3, .drops_per_m3 = 5, .velocity_m_s = {-30, 0, -9}}};

TEST(DropField, DropsStayWhereTheyAreWhileTheCameraGoesUpDownAndAround) {
  // 0 s, after a day, and 10 km from the origin; a coordinate of 1e6 m has 1e-10 m.
  for (const double time_s : {0.0, 86400.0}) {
    for (const double far_m : {0.0, 1e4}) {
      Scene scene = endless_scene(straight_and_slanted);
      scene.camera.position_m = {far_m, -far_m, 1.6};
      const auto before = field_of(scene, time_s);
      for (const Eigen::Vector3d& move :
           {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -2.4), Eigen::Vector3d(0.7, 0.2, 0.3),
            Eigen::Vector3d(-1, 1, 0)}) {
        scene.camera.position_m = Eigen::Vector3d(far_m, -far_m, 1.6) + move;
        SCOPED_TRACE(testing::Message() << time_s << " s, " << far_m << " m, " << move.transpose());
        expect_same_drops(before, field_of(scene, time_s), 0, 0.3, 1e-6);
      }
    }
  }
}

TEST(DropField, DropsFallWithTheirVelocityAcrossEveryWrap) {
  // 40 frames are 5.7 m of fall at 8.49 m/s: every drop leaves the slab once.
  const Scene scene = endless_scene(straight_and_slanted);
  for (const double start_s : {0.0, 86399.9, 1e7 - 2}) {
    auto before = field_of(scene, start_s);
    for (int frame = 1; frame <= 40; ++frame) {
      auto after = field_of(scene, start_s + frame / 60.0);
      SCOPED_TRACE(testing::Message() << start_s << " s, frame " << frame);
      // At 1e7 s a time has 2e-9 s, a fall of 1e8 m 1.5e-8 m.
      expect_same_drops(before, after, (start_s + frame / 60.0) - (start_s + (frame - 1) / 60.0),
                        0.7, 1e-6);
      before = std::move(after);
    }
  }
}

TEST(DropField, TheSlabFollowsTheCameraAndStaysInTheBox) {
  Scene scene = endless_scene({{.drops_per_m3 = 50}});
  const auto lowest_and_highest = [&] {
    double low = 1e9, high = -1e9;
    for (const Drop& drop : field_of(scene, 2)) {
      low = std::min(low, drop.centre_m.z());
      high = std::max(high, drop.centre_m.z());
    }
    return std::pair(low, high);
  };
  for (const double z_m : {-7.0, 0.0, 123.0}) {
    scene.camera.position_m.z() = z_m;
    const auto [low, high] = lowest_and_highest();
    EXPECT_NEAR(low, z_m - 2.5, 0.02);  // 12,000 drops in 5 m: 0.02 m is 48 of them
    EXPECT_NEAR(high, z_m + 2.5, 0.02);
  }
  scene.rain.box_min_m.z() = 122;
  const auto [low, high] = lowest_and_highest();
  EXPECT_NEAR(low, 122, 0.02);
  EXPECT_NEAR(high, 127, 0.02);
}

TEST(DropField, ADropDoesNotDependOnWhichTimesWereAskedForBefore) {
  const Scene scene = rain_scene(1);
  const RainSpace space = make_rain_space(scene);
  const auto first = drop_field(scene, space, 10, 12.5);
  for (double time_s : {80000.0, 0.0, 12.4999}) drop_field(scene, space, 10, time_s);
  const auto again = drop_field(scene, space, 10, 12.5);
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    ASSERT_EQ(first[k].centre_m, again[k].centre_m);
    ASSERT_EQ(first[k].oscillation, again[k].oscillation);
  }
}

TEST(DropField, TheClosedFormIsExactToAMicrometreAfterADay) {
  // Independent arithmetic: time in whole nanoseconds, 8.49 m/s = 8490 um/s and 12 m = 12e6 um give
  // the fallen height in 1e-9 um without rounding in 128 bits. The box is as high as the slab.
  const Scene scene = rain_scene(0.05);
  const auto start = by_name(field_of(scene, 0, 1));
  std::map<std::tuple<int, int, std::uint32_t>, double> start_m;
  for (const auto& [name, drop] : start)
    start_m[{name.cell_x, name.cell_y, name.number}] = drop.centre_m.z();
  for (long long ns : {86400000000000LL, 86399983333333LL, 100000000000007LL}) {
    const __int128 height = static_cast<__int128>(12000000) * 1000000000;
    const __int128 fallen = static_cast<__int128>(ns) * 8490000 % height;
    for (const Drop& drop : field_of(scene, static_cast<double>(ns) * 1e-9, 1)) {
      const auto found = start_m.find({drop.name.cell_x, drop.name.cell_y, drop.name.number});
      if (found == start_m.end()) continue;
      const auto depth = static_cast<__int128>(std::llround((12 - found->second) * 1e15));
      const double expected = 12 - static_cast<double>((depth + fallen) % height) * 1e-15;
      // 1e-6 m, except that a drop within that of the wrap may stand on either side of it.
      const double off = std::abs(drop.centre_m.z() - expected);
      EXPECT_LT(std::min(off, std::abs(12 - off)), 1e-6) << "drop " << drop.id << ", " << ns;
    }
  }
}

TEST(DropField, ABoxOfAMillimetreKeepsItsDrops) {
  Scene scene = rain_scene(1e8);
  scene.camera.position_m = {1, 1.9, 3};
  scene.rain.box_min_m = {1, 2, 3};
  scene.rain.box_max_m = {1.1, 2.001, 3.001};
  scene.rain.culling_radius_m = 0.3;
  scene.rain.local_height_m = 0.05;
  for (double time_s : {0.0, 1.0, 86400.0}) {
    const auto drops = field_of(scene, time_s, 3);
    EXPECT_NEAR(static_cast<double>(drops.size()), 10, 13);  // 24 or more: 1e-4
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
  long under_roof = 0;
  for (const Drop& drop : field_of(scene, 1)) {
    const double x = drop.centre_m.x();
    if (x > 0.1) {
      EXPECT_GT(drop.hit_time_s, 1e26);
    } else if (x < -0.1) {
      EXPECT_NEAR(drop.hit_time_s, (drop.centre_m.z() - 4) / 8.49, 1e-9);
      under_roof += drop.hit_time_s <= 0;
    }
  }
  // A third of the drops on that side (4 of 12 m): 792 +- 28.
  EXPECT_NEAR(static_cast<double>(under_roof), 792, 5 * 28);
}

TEST(DropField, ASlantedDropHitsWhereItsPathMeetsTheSurface) {
  // A table 1 m above a ground; the path of each drop is followed to the plane it meets first.
  Scene scene = rain_scene(2, {5, 1, -8});
  const auto add_level = [&](float low, float high, float z) {
    const auto first = static_cast<std::uint32_t>(scene.mesh.positions_m.size());
    for (const auto& [x, y] : {std::pair(low, low), {high, low}, {high, high}, {low, high}})
      scene.mesh.positions_m.push_back({x, y, z});
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) scene.mesh.indices.push_back(first + i);
  };
  add_level(-40, 60, 0);
  add_level(-2, 6, 1);
  long on_table = 0;
  for (const Drop& drop : field_of(scene, 1)) {
    const double to_table_s = (drop.centre_m.z() - 1) / 8, to_ground_s = drop.centre_m.z() / 8;
    const Eigen::Vector3d at = drop.centre_m + to_table_s * drop.velocity_m_s;
    const double inside = std::min({at.x() + 2, 6 - at.x(), at.y() + 2, 6 - at.y()});
    if (std::abs(inside) < 0.2) continue;  // the table's rim is known to a texel
    EXPECT_NEAR(drop.hit_time_s, inside > 0 ? to_table_s : to_ground_s, 1e-6) << at.transpose();
    on_table += inside > 0;
  }
  EXPECT_GT(on_table, 300);
}

TEST(DropField, SingleDropsComeLastAndFallAsTold) {
  Scene scene = rain_scene(0.01);
  scene.drops = {
      {.centre_m = {1, 2, 30}, .r0_m = 1e-3, .velocity_m_s = {1, 0, -6}, .oscillation = 7},
      {.centre_m = {3, 3, 3}, .oscillation = 12}};
  const auto drops = field_of(scene, 2);
  ASSERT_GE(drops.size(), 2u);
  const Drop& first = drops[drops.size() - 2];
  EXPECT_TRUE(first.name.single);
  EXPECT_LT((first.centre_m - Eigen::Vector3d(3, 2, 18)).norm(), 1e-12);
  EXPECT_EQ(first.oscillation, 7);
  EXPECT_EQ(first.r0_m, 1e-3);
  EXPECT_GT(first.hit_time_s, 1e26);
  EXPECT_EQ(drops.back().oscillation, 2);  // 12 of 10 sets
}

TEST(DropField, ATimeBeforeTheStartOrWithoutNumberIsRefused) {
  for (double time_s : {-1.0, 1.1e7, std::nan(""), HUGE_VAL})
    EXPECT_NE(message_of([&] { field_of(rain_scene(1), time_s); }).find("expected 0 .. 1"),
              std::string::npos)
        << time_s;
}

TEST(DropField, DropsGetTheNumbersOfTheSetsThatThereAre) {
  Scene scene = rain_scene(1);
  scene.drops = {{.centre_m = {0, 8, 6}, .oscillation = 4}};  // the second of three
  const std::vector<int> sets = {2, 3, 9};
  const std::vector<Drop> places = field_of(scene, 0.3, 3);
  const std::vector<Drop> drops = drops_with_sets(scene, sets, 0.3);
  ASSERT_EQ(drops.size(), places.size());
  ASSERT_GT(drops.size(), 1000u);
  for (std::size_t i = 0; i < drops.size(); ++i)
    ASSERT_EQ(drops[i].oscillation, sets[static_cast<std::size_t>(places[i].oscillation)]);
  EXPECT_EQ(drops.back().oscillation, 3);
}

}  // namespace
}  // namespace pluvia
