#include "raytrace/isa.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace pluvia {
namespace {

constexpr Isa all_isas[] = {Isa::scalar, Isa::avx2, Isa::avx512};

TEST(Isa, TheWiderTheSetTheMoreItNeeds) {
  // No processor has AVX-512 without AVX2 and FMA; the compiler's own reading of the processor is
  // the second road.
  EXPECT_TRUE(cpu_has(Isa::scalar));
  EXPECT_LE(cpu_has(Isa::avx512), cpu_has(Isa::avx2));
  EXPECT_LE(cpu_has(Isa::avx2), __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"));
  EXPECT_LE(cpu_has(Isa::avx512),
            __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl"));
}

TEST(Isa, TheBestIsTheWidestThatTheProcessorHas) {
  Isa widest = Isa::scalar;
  for (const Isa isa : all_isas) {
    if (cpu_has(isa)) widest = isa;
  }
  EXPECT_EQ(best_isa(), widest);
}

TEST(Isa, ANameLeadsBackToItsSetOrTellsWhatThisProcessorHas) {
  for (const Isa isa : all_isas) {
    if (cpu_has(isa)) {
      EXPECT_EQ(isa_from_name(isa_name(isa)), isa);
      continue;
    }
    try {
      isa_from_name(isa_name(isa));
      FAIL() << isa_name(isa);
    } catch (const std::runtime_error& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.find("instruction set \"" + isa_name(isa) + "\" is not in this processor"), 0u)
          << text;
      EXPECT_NE(text.find("scalar"), std::string::npos) << text;
    }
  }
}

TEST(Isa, OtherNamesAreRefused) {
  for (const std::string name : {"", "AVX2", "sse2", "avx512f", "avx2\nscalar"}) {
    EXPECT_THROW(isa_from_name(name), std::runtime_error) << name;
  }
  try {
    isa_from_name("neon");
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("instruction set \"neon\"; expected one of scalar"), 0u) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace pluvia
