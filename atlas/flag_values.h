// Values of flags that CLI11 has no validator for.
#pragma once

#include <CLI/CLI.hpp>

namespace pluvia {

// A number from low to high. CLI::Range lets nan pass: it is neither below the range nor above.
CLI::Validator finite_range(double low, double high);

}  // namespace pluvia
