// Random numbers that are a function of a key: what is drawn for one sample does not depend on any
// other sample, nor on the thread. SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom
// Number Generators", OOPSLA 2014).
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace pluvia {

constexpr std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

struct CounterRandom {
  std::uint64_t state = 0;

  // Keys that differ anywhere give independent sequences.
  explicit CounterRandom(std::initializer_list<std::uint64_t> key) {
    for (const std::uint64_t word : key) state = mixed(state + 0x9E3779B97F4A7C15u + word);
  }

  // Uniform in [0, 1).
  double next() {
    state += 0x9E3779B97F4A7C15u;
    return std::ldexp(static_cast<double>(mixed(state) >> 11), -53);
  }
};

}  // namespace pluvia
