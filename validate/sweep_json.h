// sweep.json: a Sweep (validate/sweep.h) as a file, version 1. docs/fidelity.md has the keys.
#pragma once

#include <string>

#include "validate/sweep.h"

namespace pluvia {

std::string sweep_json(const Sweep& sweep);

// Throws std::runtime_error: "FILE:LINE:COL: not JSON: ..", "FILE: KEY: found; expected" for a key
// that is missing or of another type, a value out of range, a curve or setting that comes twice, an
// on_front that is not what times and errors say, and a recommended setting that is not on the
// front.
Sweep read_sweep(const std::string& file);

}  // namespace pluvia
