// Values of flags that CLI11 has no validator for.
#pragma once

#include <CLI/CLI.hpp>

namespace pluvia {

// A number from low to high. CLI::Range lets nan pass: it is neither below the range nor above.
CLI::Validator finite_range(double low, double high);

// A time > 0 and at most 1e9 s, as a number and ms, s, min or h; s without. Leaves seconds as a
// plain number behind: for options of type double.
CLI::Validator duration_in_seconds();

}  // namespace pluvia
