// The whole fidelity report in one call.
#pragma once

#include <string>
#include <vector>

#include "raytrace/generate.h"
#include "validate/report.h"

namespace pluvia {

enum class ReportDepth {
  quick,  // without the long checks, which the report tells under `skipped`: field.*, reference.*
          // and tags.* of traced streaks; frames at most 320 pixels wide
  usual,
  full  // every approximation priced: some 20 minutes more
};

struct FidelityInputs {
  std::string database_folder = {};
  std::string atlas_folder = {};
  std::string data_folder = {};  // data/ of the project
  // Of the frames that are checked against the composite. The checks of the first are named
  // frame.*, those of the others frame.NAME.*, after their files.
  std::vector<std::string> scene_files = {};
  double time_s = 1;  // shutter-open of the checked frames
  ReportDepth depth = ReportDepth::usual;
  std::vector<std::string> commands = {};  // for the report
};

// Throws std::runtime_error for inputs that cannot be read, no scene, or two of one name; a failed
// check is not an error.
Report measure_fidelity(const FidelityInputs& inputs, const Progress& progress = {});

}  // namespace pluvia
