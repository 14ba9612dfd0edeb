#include "atlas/flag_values.h"

#include <map>
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

CLI::Validator duration_in_seconds() {
  const auto convert = [](std::string& text) {
    static const std::map<std::string, double> units = {
        {"", 1}, {"ms", 1e-3}, {"s", 1}, {"min", 60}, {"h", 3600}};
    const std::size_t last = text.find_last_of("0123456789.");
    const std::size_t end = last == std::string::npos ? 0 : last + 1;
    const auto unit = units.find(text.substr(end));
    double value = 0;
    const bool known = unit != units.end() && CLI::detail::lexical_cast(text.substr(0, end), value);
    const double time_s = known ? value * unit->second : 0;
    if (!(time_s > 0 && time_s <= 1e9)) {
      return fmt::format("{}; expected a time such as 90s, 5min or 1h, > 0 and at most 1e9 s",
                         text);
    }
    text = fmt::format("{}", time_s);
    return std::string();
  };
  return {convert, "TIME"};
}

}  // namespace pluvia
