// The whole fidelity report in one call.
#pragma once

#include <string>
#include <vector>

#include "raytrace/generate.h"
#include "validate/report.h"

namespace pluvia {

struct FidelityInputs {
  std::string database_folder = {};
  std::string atlas_folder = {};
  std::string data_folder = {};            // data/ of the project
  std::string scene_file = {};             // of the frame that is checked against the composite
  double time_s = 1;                       // shutter-open of the checked frame
  bool full = false;                       // price every approximation: some 20 minutes more
  std::vector<std::string> commands = {};  // for the report
};

// Throws std::runtime_error for inputs that cannot be read; a failed check is not an error.
Report measure_fidelity(const FidelityInputs& inputs, const Progress& progress = {});

}  // namespace pluvia
