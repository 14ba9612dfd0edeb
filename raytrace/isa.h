// The instruction sets that the tracing of paths knows. Results differ between sets by rounding
// (raytrace/wide_paths.h says by how much), within one set not by a bit.
#pragma once

#include <string>

namespace pluvia {

enum class Isa {
  scalar,  // any processor; one path at a time
  avx2,    // 4 paths at a time; needs AVX2, FMA, BMI and BMI2
  avx512   // 8 paths at a time; needs AVX-512 F, CD, DQ, BW and VL
};

// Whether this processor and its operating system can run the set.
bool cpu_has(Isa isa);

// The widest set that the processor has.
Isa best_isa();

// "scalar", "avx2", "avx512".
std::string isa_name(Isa isa);

// The set of that name. Throws std::runtime_error, one line, for another name and for a set that
// this processor lacks; the message names those that it has.
Isa isa_from_name(const std::string& name);

}  // namespace pluvia
