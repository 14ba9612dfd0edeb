// The sets that this processor can run, and whether two runs gave the same bytes.
#pragma once

#include <cstring>
#include <vector>

#include <Eigen/Core>

#include "raytrace/isa.h"

namespace pluvia {

inline std::vector<Isa> wide_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::avx2, Isa::avx512}) {
    if (cpu_has(isa)) isas.push_back(isa);
  }
  return isas;
}

inline bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

inline bool same_bits(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return same_bits(a.x(), b.x()) && same_bits(a.y(), b.y()) && same_bits(a.z(), b.z());
}

}  // namespace pluvia
