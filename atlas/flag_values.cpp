#include "atlas/flag_values.h"

#include <string>

#include <fmt/format.h>

namespace pluvia {

CLI::Validator finite_range(double low, double high) {
  const auto check = [low, high](const std::string& text) {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high)
      return std::string();
    return fmt::format("{}; expected {} .. {}", text, low, high);
  };
  return {check, fmt::format("FLOAT in [{} - {}]", low, high)};
}

}  // namespace pluvia
