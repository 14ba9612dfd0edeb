#include "raytrace/isa.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>
#include <hwy/targets.h>

namespace pluvia {

namespace {

constexpr std::array all_isas = {Isa::scalar, Isa::avx2, Isa::avx512};

std::string names_here() {
  std::string names;
  for (const Isa isa : all_isas) {
    if (cpu_has(isa)) names += (names.empty() ? "" : ", ") + isa_name(isa);
  }
  return names;
}

}  // namespace

bool cpu_has(Isa isa) {
  switch (isa) {
    case Isa::scalar:
      return true;
    case Isa::avx2:
      return (hwy::SupportedTargets() & HWY_AVX2) != 0;
    case Isa::avx512:
      return (hwy::SupportedTargets() & HWY_AVX3) != 0;
  }
  return false;
}

Isa best_isa() {
  return *std::find_if(all_isas.rbegin(), all_isas.rend(), cpu_has);
}

std::string isa_name(Isa isa) {
  switch (isa) {
    case Isa::avx2:
      return "avx2";
    case Isa::avx512:
      return "avx512";
    case Isa::scalar:
      break;
  }
  return "scalar";
}

Isa isa_from_name(const std::string& name) {
  const auto* const found = std::find_if(all_isas.begin(), all_isas.end(),
                                         [&](Isa isa) { return isa_name(isa) == name; });
  if (found == all_isas.end()) {
    throw std::runtime_error(
        fmt::format("instruction set \"{}\"; expected one of {}", name, names_here()));
  }
  if (!cpu_has(*found)) {
    throw std::runtime_error(fmt::format(
        "instruction set \"{}\" is not in this processor; expected one of {}", name, names_here()));
  }
  return *found;
}

}  // namespace pluvia
