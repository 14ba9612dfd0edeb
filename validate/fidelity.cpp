#include "validate/fidelity.h"

#include <chrono>

#include "validate/checks.h"

namespace pluvia {

Report measure_fidelity(const FidelityInputs& inputs, const Progress& progress) {
  Report report;
  report.machine = describe_machine();
  report.commands = inputs.commands;
  const auto step = [&](const std::string& what, double share) {
    if (progress) progress(what, share);
  };
  const auto start = std::chrono::steady_clock::now();
  const Preset preset = read_preset(inputs.data_folder + "/presets/gn2006.toml");
  step("sphere", 0);
  add_sphere_checks(report);
  step("furnace", 0.05);
  add_energy_check(preset, report);
  add_mesh_check(preset, report);
  add_field_checks(
      preset, [&](const std::string& what, double share) { step(what, 0.1 + 0.7 * share); },
      report);
  step("real factors", 0.8);
  add_database_checks(inputs.database_folder,
                      inputs.data_folder + "/factors/garg_nayar_2006_point_factors.csv", report);
  add_gallery(inputs.database_folder, report);
  step("frame", 0.85);
  add_frame_check(inputs.scene_file, inputs.atlas_folder, inputs.time_s, report);
  step("report", 1);
  report.timings_s.emplace_back(
      "all checks",
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return report;
}

}  // namespace pluvia
