#include "raytrace/drop_field.h"

#include <cassert>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

constexpr double longest_time_s = 1e7;

// In [0, 1): 32 bits are exact in a double.
double fraction(std::uint32_t bits) {
  return std::ldexp(bits, -32);
}

}  // namespace

std::array<std::uint32_t, 3> rain_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::array<std::uint32_t, 3> v = {a, b, c};
  const auto mix = [&v] {
    v[0] += v[1] * v[2];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
  };
  for (std::uint32_t& word : v) word = word * 1664525u + 1013904223u;
  mix();
  for (std::uint32_t& word : v) word ^= word >> 16;
  mix();
  return v;
}

RainSeeds rain_seeds(std::uint64_t seed) {
  const auto hash =
      rain_hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), 0);
  return {hash[0], hash[1]};
}

FallState fall_state(const Rain& rain, double time_s) {
  if (!(time_s >= 0 && time_s <= longest_time_s))
    throw std::runtime_error(
        fmt::format("rain at time {} s; expected 0 .. {} s", time_s, longest_time_s));
  const double height_m = rain.box_max_m.z() - rain.box_min_m.z();
  const double fallen_m = time_s * rain.fall_speed_m_s;
  const double offset_m = std::fmod(fallen_m, height_m);  // exact, and < height
  const double rounds = std::round((fallen_m - offset_m) / height_m);
  return {static_cast<std::uint32_t>(std::ldexp(offset_m / height_m, 32)),
          static_cast<std::uint32_t>(static_cast<std::uint64_t>(rounds))};
}

std::uint32_t drop_count(const Rain& rain) {
  return static_cast<std::uint32_t>(
      std::llround(rain.drops_per_m3 * (rain.box_max_m - rain.box_min_m).prod()));
}

std::vector<Drop> drop_field(const Scene& scene, const TopHeight& top, int oscillation_count,
                             double time_s) {
  assert(oscillation_count >= 1);
  const Rain& rain = scene.rain;
  const Eigen::Vector3d size = rain.box_max_m - rain.box_min_m;
  const RainSeeds seeds = rain_seeds(rain.seed);
  const FallState fallen = fall_state(rain, time_s);
  std::vector<Drop> drops(drop_count(rain));
  for (std::uint32_t k = 0; k < drops.size(); ++k) {
    const std::uint32_t start = rain_hash(seeds.phase, k, 0)[0];
    const std::uint32_t phase = start + fallen.phase;
    const std::uint32_t round = fallen.round + (phase < start ? 1 : 0);
    const auto place = rain_hash(seeds.place, k, round);
    Drop& drop = drops[k];
    drop.id = k;
    drop.centre_m = {rain.box_min_m.x() + size.x() * fraction(place[0]),
                     rain.box_min_m.y() + size.y() * fraction(place[1]),
                     rain.box_max_m.z() - size.z() * fraction(phase)};
    drop.velocity_m_s = {0, 0, -rain.fall_speed_m_s};
    drop.r0_m = rain.mean_radius_m;
    drop.oscillation = static_cast<int>(
        (static_cast<std::uint64_t>(place[2]) * static_cast<std::uint64_t>(oscillation_count)) >>
        32);
    const double surface_m = height_at(top, drop.centre_m.x(), drop.centre_m.y());
    drop.hit_time_s = (drop.centre_m.z() - surface_m) / rain.fall_speed_m_s;
  }
  return drops;
}

}  // namespace pluvia
