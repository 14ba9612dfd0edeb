// What each approximation costs, as the report's tables and checks, in Markdown:
//   price_study PRESET [--full] [--streaks] [--atlas DIR [--reference] [--frame] [--drawing]]
//   [--out DIR]
#include <exception>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "raytrace/preset.h"
#include "validate/checks.h"

namespace pluvia {
namespace {

void print(const Report& report) {
  for (const Table& table : report.tables) {
    fmt::print("\n## {}\n", table.title);
    const auto print_row = [](const std::vector<std::string>& row) {
      for (const std::string& cell : row) fmt::print("| {} ", cell);
      fmt::print("|\n");
    };
    print_row(table.head);
    print_row(std::vector<std::string>(table.head.size(), "---"));
    for (const auto& row : table.rows) print_row(row);
  }
  for (const Check& check : report.checks)
    fmt::print("{} {} {:.4g} +- {:.2g}, bound {:.4g}\n", passes(check) ? "ok" : "FAIL", check.name,
               check.value, check.uncertainty, check.bound);
  for (const auto& [name, seconds] : report.timings_s) fmt::print("{}: {:.1f} s\n", name, seconds);
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  using namespace pluvia;
  CLI::App app("what each approximation costs");
  std::string preset_file, atlas_folder, out;
  bool streaks = false, full = false, reference = false, frame = false, drawing = false;
  app.add_flag("--frame", frame, "a whole frame against the reference");
  app.add_flag("--drawing", drawing, "drawing, near drops, near lamps");
  app.add_flag("--streaks", streaks, "single streaks of two drops");
  app.add_option("preset", preset_file, "whose drops are traced")->required();
  app.add_option("--atlas", atlas_folder, "whose levels and formats are priced");
  app.add_flag("--full", full, "of each more: also grids, sizes, skies; lookups of the frame");
  app.add_flag("--reference", reference, "drops against the reference tracer, too");
  app.add_option("--out", out, "folder of the same as a page");
  CLI11_PARSE(app, argc, argv);
  try {
    Report report;
    const Preset preset = read_preset(preset_file);
    if (streaks)
      add_streak_prices(preset, PLUVIA_DATA_DIR, full ? StudyDepth::full : StudyDepth::brief, {},
                        report);
    if (!atlas_folder.empty()) {
      const StreakAtlas atlas = read_atlas(atlas_folder);
      add_format_prices(atlas, report);
      if (frame)
        add_whole_frame_check(preset, atlas, PLUVIA_DATA_DIR,
                              full ? StudyDepth::full : StudyDepth::brief, report);
      if (drawing)
        add_frame_prices(PLUVIA_DATA_DIR "/scenes/street.toml", atlas, preset, {}, report);
      if (reference) add_reference_checks(preset, atlas, {}, report);
    }
    print(report);
    if (!out.empty()) write_report(out, report);
  } catch (const std::exception& error) {
    fmt::print(stderr, "price_study: {}\n", error.what());
    return 1;
  }
  return 0;
}
